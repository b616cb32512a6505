#include "host_asset.h"

#include <algorithm>
#include <memory>

#include "furrow/skinning.h"

using namespace furrow;

FurrowAsset::FurrowAsset(FurrowContext& host)
    : context(host), memory(host.memory), joints(&memory), weights(&memory), clusters(&memory) {
  retain(host.references);
}

FurrowAsset::~FurrowAsset() = default;

FurrowBinding::FurrowBinding(FurrowAsset& bound, uint32_t vertices)
    : asset(bound),
      points(vertices, kUnmatched, &bound.context.memory),
      element(bound.view.vertexCount(), kAbsent, &bound.context.memory) {
  furrow_asset_retain(&asset);
}

FurrowBinding::~FurrowBinding() = default;

namespace furrow {

Status readStream(const FurrowStream& stream, const char* name, VertexStream& out) {
  if (!stream.data) return Status::error(StatusCode::kInvalidArgument, "%s.data is NULL", name);
  if (stream.format > FURROW_HALF3)
    return Status::error(StatusCode::kInvalidArgument, "%s.format is unknown", name);
  out.format = static_cast<VertexFormat>(stream.format);
  const size_t tight = out.format == VertexFormat::kFloat3 ? 12 : 6;
  out.bytes = {static_cast<const std::byte*>(stream.data), stream.bytes};
  out.offset = stream.offset;
  out.stride = stream.stride == 0 ? tight : stream.stride;
  return {};
}

namespace {

// Of what is not handed out after all.
struct Release {
  void operator()(FurrowAsset* asset) const { furrow_asset_release(asset); }
  void operator()(FurrowBinding* binding) const { furrow_binding_release(binding); }
};

// Strings of an asset end in 0 or are empty.
const char* nameOf(std::string_view name) {
  return name.empty() ? "" : name.data();
}

uint32_t countOf(const auto& span) {
  return static_cast<uint32_t>(span.size());
}

Status keepInfluences(FurrowAsset& asset, uint32_t keep) {
  if (keep == 0 || keep >= asset.view.influences) return {};
  const size_t count = size_t{asset.view.vertexCount()} * keep;
  asset.joints.resize(count);
  asset.weights.resize(count);
  const InfluencesJob job{&asset.view, keep, asset.joints, asset.weights};
  if (Status s = job.validate(); !s.ok()) return s;
  job.run(0, asset.view.vertexCount());
  asset.view.influences = keep;
  asset.view.joints = asset.joints;
  asset.view.weights = asset.weights;
  return {};
}

Status loadAsset(FurrowAsset& asset, const FurrowAssetDesc& desc) {
  const std::span bytes(static_cast<const std::byte*>(desc.bytes), desc.byte_count);
  if (Status s = asset.asset.load(bytes, &asset.memory); !s.ok()) return s;
  asset.view = asset.asset.view();
  if (Status s = keepInfluences(asset, desc.influences); !s.ok()) return s;
  if (desc.flags & FURROW_ASSET_STAGED) return {};
  const Status s = asset.clusters.build(asset.view);
  if (s.code != StatusCode::kUnavailable) return s;
  asset.context.log(FURROW_LOG_WARNING, s.message);  // staged frames do it all
  return {};
}

template <typename Info, typename Fill>
int32_t describe(const FurrowAsset* asset, size_t index, size_t count, const char* what, Info* info,
                 FurrowStatus* status, Fill fill) {
  return guarded(status, [&]() -> Status {
    if (!asset) return invalid("asset is NULL");
    if (index >= count)
      return Status::error(StatusCode::kInvalidArgument, "%s %zu, the asset has %zu", what, index, count);
    Info value = {};
    fill(value);
    return writeStruct(value, info);
  });
}

template <typename Items>
uint32_t findName(const Items& items, const char* name) {
  for (size_t i = 0; name && i < items.size(); ++i)
    if (items[i].name == name) return static_cast<uint32_t>(i);
  return FURROW_NONE;
}

FurrowTexture describeTexture(const Texture& texture) {
  return {static_cast<uint32_t>(texture.format),
          texture.width,
          texture.height,
          texture.slices,
          texture.levels,
          texture.data.data(),
          texture.data.size()};
}
static_assert(static_cast<int>(TextureFormat::kBc5) == FURROW_FORMAT_BC5 &&
              static_cast<int>(TextureFormat::kBc4) == FURROW_FORMAT_BC4 &&
              static_cast<int>(TextureFormat::kRgba8) == FURROW_FORMAT_RGBA8);
static_assert(kMaxLayers == FURROW_MAX_LAYERS && kAbsent == FURROW_NONE && kUnmatched == FURROW_NONE &&
              kAmbiguous == FURROW_NONE - 1);
static_assert(static_cast<int>(Measure::kNone) == FURROW_MEASURE_NONE &&
              static_cast<int>(Curve::kOat) == FURROW_CURVE_OAT);

Status bind(FurrowAsset& asset, const FurrowBindDesc& desc, const VertexStream& from, FurrowBinding& binding,
            FurrowBindCounts& counts) {
  FurrowContext& context = asset.context;
  std::pmr::vector<Float3> positions(desc.vertices, &context.memory);
  PoseJob unpack;
  unpack.from = from;
  unpack.out = positions;
  if (Status s = unpack.validate(); !s.ok()) return s;
  unpack.run(0, desc.vertices);

  BindJob job;
  job.asset = &asset.view;
  job.positions = positions;
  if (desc.indices) job.indices = {desc.indices, desc.index_count};
  if (std::any_of(desc.to_root, desc.to_root + 12, [](float value) { return value != 0.0f; }))
    std::copy_n(desc.to_root, 12, job.to_root.m);
  job.tolerance = desc.tolerance;
  std::pmr::vector<uint32_t> scratch(job.scratchSize(), &context.memory);
  job.scratch = scratch;
  job.points = binding.points;
  if (Status s = job.validate(); !s.ok()) return s;
  const BindCounts result = job.run();

  std::pmr::vector<uint32_t> vertex_of(asset.view.pointCount(), kAbsent, &context.memory);
  for (uint32_t v = desc.vertices; v-- > 0;)
    if (binding.points[v] < asset.view.pointCount()) vertex_of[binding.points[v]] = v;
  for (size_t v = 0; v < binding.element.size(); ++v)
    binding.element[v] = vertex_of[asset.view.vertex_point[v]];
  counts.matched = result.matched;
  counts.ambiguous = result.ambiguous;
  counts.unmatched = result.unmatched;
  counts.missing = static_cast<uint32_t>(std::count(vertex_of.begin(), vertex_of.end(), kAbsent));
  return {};
}

}  // namespace
}  // namespace furrow

int32_t furrow_asset_create(FurrowContext* context, const FurrowAssetDesc* desc, FurrowAsset** asset,
                            FurrowStatus* status) {
  if (asset) *asset = nullptr;
  return guarded(status, [&]() -> Status {
    if (!context || !asset) return invalid(context ? "asset is NULL" : "context is NULL");
    FurrowAssetDesc wanted;
    if (Status s = readStruct(desc, wanted, "desc"); !s.ok()) return s;
    if (!wanted.bytes) return invalid("desc.bytes is NULL");
    if (wanted.flags & ~uint32_t{FURROW_ASSET_STAGED}) return invalid("desc.flags has an unknown flag");
    std::unique_ptr<FurrowAsset, Release> made(create<FurrowAsset>(*context, *context));
    if (Status s = loadAsset(*made, wanted); !s.ok()) return s;
    *asset = made.release();
    return {};
  });
}

void furrow_asset_retain(FurrowAsset* asset) {
  if (asset) retain(asset->references);
}

void furrow_asset_release(FurrowAsset* asset) {
  if (!asset || !released(asset->references)) return;
  FurrowContext& context = asset->context;
  destroy(context, asset);
  furrow_context_release(&context);
}

int32_t furrow_asset_info(const FurrowAsset* asset, FurrowAssetInfo* info, FurrowStatus* status) {
  return describe(asset, 0, 1, "asset", info, status, [&](FurrowAssetInfo& out) {
    const AssetView& view = asset->view;
    out.vertices = view.vertexCount();
    out.triangles = view.triangleCount();
    out.points = view.pointCount();
    out.layers = view.layerCount();
    out.morphs = countOf(view.morphs);
    out.palette = countOf(view.palette);
    out.parts = countOf(view.parts);
    out.texture_sets = countOf(view.texture_sets);
    out.drivers = countOf(view.drivers);
    out.influences = view.influences;
    out.weight_stride = view.weightStride();
    out.clustered = asset->clusters.asset != nullptr;
    out.position_error = view.position_error;
    out.morph_error = view.morph_error;
    for (const TextureSet& set : view.texture_sets)
      for (const Texture* texture : {&set.normals, &set.shading, &set.masks})
        out.texture_bytes += texture->data.size();
    out.memory_bytes = sizeof(FurrowAsset) + asset->memory.bytes();
    out.source = nameOf(view.source);
    out.tool_version = nameOf(view.tool_version);
  });
}

int32_t furrow_asset_geometry(const FurrowAsset* asset, FurrowGeometry* geometry, FurrowStatus* status) {
  return describe(asset, 0, 1, "asset", geometry, status, [&](FurrowGeometry& out) {
    const AssetView& view = asset->view;
    out.positions = &view.positions.data()->x;
    out.normals = &view.normals.data()->x;
    out.tangents = &view.tangents.data()->x;
    out.uvs = &view.uvs.data()->x;
    out.indices = view.indices.data();
    out.source_vertex = view.source_vertex.data();
    out.vertex_point = view.vertex_point.data();
    out.point_vertex = view.point_vertex.data();
  });
}

int32_t furrow_layer_info(const FurrowAsset* asset, uint32_t layer, FurrowLayerInfo* info,
                          FurrowStatus* status) {
  return describe(
      asset, layer, asset ? asset->view.layers.size() : 0, "layer", info, status, [&](FurrowLayerInfo& out) {
        const Layer& from = asset->view.layers[layer];
        const Response& r = from.response;
        out.name = nameOf(from.name);
        out.measure = static_cast<uint32_t>(from.measure);
        out.response = {static_cast<uint32_t>(r.curve), r.lambda, r.beta, r.stretch_lambda, r.stretch_beta};
        out.has_bias = !from.bias.empty();
        out.mask_slice = from.mask_slice;
        out.mask = from.mask.empty() ? nullptr : from.mask.data();
        out.driver_begin = from.driver_begin;
        out.driver_end = from.driver_end;
      });
}

uint32_t furrow_layer_find(const FurrowAsset* asset, const char* name) {
  return asset ? findName(asset->view.layers, name) : FURROW_NONE;
}

int32_t furrow_morph_info(const FurrowAsset* asset, uint32_t morph, FurrowMorphInfo* info,
                          FurrowStatus* status) {
  return describe(asset, morph, asset ? asset->view.morphs.size() : 0, "morph", info, status,
                  [&](FurrowMorphInfo& out) {
                    const Morph& from = asset->view.morphs[morph];
                    out.name = nameOf(from.name);
                    out.default_weight = from.default_weight;
                    out.vertices = countOf(from.vertices);
                    out.moved = from.vertices.data();
                  });
}

uint32_t furrow_morph_find(const FurrowAsset* asset, const char* name) {
  return asset ? findName(asset->view.morphs, name) : FURROW_NONE;
}

int32_t furrow_palette_info(const FurrowAsset* asset, uint32_t entry, FurrowPaletteInfo* info,
                            FurrowStatus* status) {
  return describe(asset, entry, asset ? asset->view.palette.size() : 0, "palette entry", info, status,
                  [&](FurrowPaletteInfo& out) {
                    const PaletteEntry& from = asset->view.palette[entry];
                    out.node = nameOf(from.node);
                    out.node_index = from.node_index;
                    std::copy_n(from.inverse_bind.m, 12, out.inverse_bind);
                  });
}

int32_t furrow_part_info(const FurrowAsset* asset, uint32_t part, FurrowPartInfo* info,
                         FurrowStatus* status) {
  return describe(asset, part, asset ? asset->view.parts.size() : 0, "part", info, status,
                  [&](FurrowPartInfo& out) {
                    const Part& from = asset->view.parts[part];
                    out.mesh = nameOf(from.mesh);
                    out.material = nameOf(from.material);
                    out.vertex_begin = from.vertex_begin;
                    out.vertex_end = from.vertex_end;
                    out.triangle_begin = from.triangle_begin;
                    out.triangle_end = from.triangle_end;
                    out.source_vertex_begin = from.source_vertex_begin;
                    out.texture_set = from.texture_set;
                    std::copy_n(&from.base_color.x, 4, out.base_color);
                    std::copy_n(from.rest.m, 12, out.rest);
                  });
}

int32_t furrow_driver_info(const FurrowAsset* asset, uint32_t driver, FurrowDriverInfo* info,
                           FurrowStatus* status) {
  return describe(asset, driver, asset ? asset->view.drivers.size() : 0, "driver", info, status,
                  [&](FurrowDriverInfo& out) {
                    const Driver& from = asset->view.drivers[driver];
                    out.morph = from.morph;
                    out.gain = from.gain;
                    out.curve_points = countOf(from.curve);
                    out.curve = from.curve.empty() ? nullptr : &from.curve.data()->x;
                  });
}

int32_t furrow_texture_set_info(const FurrowAsset* asset, uint32_t set, FurrowTextureSetInfo* info,
                                FurrowStatus* status) {
  return describe(asset, set, asset ? asset->view.texture_sets.size() : 0, "texture set", info, status,
                  [&](FurrowTextureSetInfo& out) {
                    const TextureSet& from = asset->view.texture_sets[set];
                    out.name = nameOf(from.name);
                    out.normals = describeTexture(from.normals);
                    out.shading = describeTexture(from.shading);
                    out.masks = describeTexture(from.masks);
                    std::copy_n(from.compress_slice, kMaxLayers, out.compress_slice);
                    std::copy_n(from.stretch_slice, kMaxLayers, out.stretch_slice);
                    static_assert(sizeof from.windows == sizeof out.windows);
                    std::memcpy(out.windows, from.windows, sizeof out.windows);
                  });
}

size_t furrow_texture_level_bytes(uint32_t format, uint32_t width, uint32_t height, uint32_t level) {
  if (format > FURROW_FORMAT_RGBA8 || level > 31) return 0;
  return textureLevelBytes(static_cast<TextureFormat>(format), width, height, level);
}

int32_t furrow_binding_create(FurrowAsset* asset, const FurrowBindDesc* desc, FurrowBinding** binding,
                              FurrowBindCounts* counts, FurrowStatus* status) {
  if (binding) *binding = nullptr;
  return guarded(status, [&]() -> Status {
    if (!asset || !binding) return invalid(asset ? "binding is NULL" : "asset is NULL");
    FurrowBindDesc wanted;
    if (Status s = readStruct(desc, wanted, "desc"); !s.ok()) return s;
    VertexStream from;
    if (Status s = readStream(wanted.positions, "positions", from); !s.ok()) return s;
    if (from.count() < wanted.vertices)
      return Status::error(StatusCode::kInvalidArgument, "desc.positions holds fewer than %u vertices",
                           wanted.vertices);
    FurrowBindCounts found = {};
    std::unique_ptr<FurrowBinding, Release> made(
        create<FurrowBinding>(asset->context, *asset, wanted.vertices));
    if (Status s = bind(*asset, wanted, from, *made, found); !s.ok()) return s;
    if (counts)
      if (Status s = writeStruct(found, counts); !s.ok()) return s;
    *binding = made.release();
    return {};
  });
}

void furrow_binding_release(FurrowBinding* binding) {
  if (!binding) return;
  FurrowAsset& asset = binding->asset;
  destroy(asset.context, binding);
  furrow_asset_release(&asset);
}

const uint32_t* furrow_binding_points(const FurrowBinding* binding) {
  return binding ? binding->points.data() : nullptr;
}

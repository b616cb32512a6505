#include "furrow/asset.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <new>
#include <vector>

#include "asset_header.h"
#include "direction_codec.h"
#include "furrow_generated.h"
#include "morph_codec.h"
#include "part_geometry.h"
#include "rest_surface.h"

namespace furrow {

// Everything an asset keeps, in the host's memory.
struct Asset::Storage {
  explicit Storage(std::pmr::memory_resource* host) : memory(host) {}

  template <typename T>
  using Array = std::pmr::vector<T>;
  template <typename T>
  using Arrays = std::pmr::deque<std::pmr::vector<T>>;  // does not move its elements

  std::pmr::memory_resource* memory;
  // Of all parts; indices and joints absolute.
  Array<Float3> positions{memory}, normals{memory};
  Array<Float4> tangents{memory};
  Array<Float2> uvs{memory};
  Array<uint16_t> joints{memory}, weights{memory};
  Array<uint32_t> source{memory}, indices{memory};
  Array<uint32_t> vertex_point{memory}, surface_indices{memory}, point_vertex{memory}, morph_entries{memory},
      place_points{memory};
  Array<uint32_t> ring_offsets{memory}, ring_triangles{memory};
  Array<uint16_t> ring_weights{memory};
  Array<Part> parts{memory};
  Array<PaletteEntry> palette{memory};
  Array<Morph> morphs{memory};
  Array<Layer> layers{memory};
  Array<Driver> drivers{memory};
  Array<TextureSet> texture_sets{memory};
  Array<BaseMaps> base_maps{memory};
  Array<std::byte> rig{memory}, place_hash{memory};
  std::string_view tool_version, source_file;
  // What names, morphs, layers and drivers point into.
  Arrays<char> names{memory};
  Arrays<Float2> curves{memory};
  Arrays<uint32_t> words{memory};
  Arrays<int32_t> integers{memory};
  Arrays<int16_t> shorts{memory};
  Arrays<int8_t> bytes{memory};
  Arrays<float> floats{memory};
  Array<uint8_t> colors{memory};
  Arrays<std::byte> texels{memory};
};

void Asset::Free::operator()(Storage* storage) const {
  std::pmr::polymorphic_allocator<>(storage->memory).delete_object(storage);
}

namespace {

Status bad(const char* what) {
  return Status::error(StatusCode::kBadData, "%s", what);
}

bool readAffine(const flatbuffers::Vector<float>* numbers, Affine& out) {
  if (!numbers || numbers->size() != 12) return false;
  for (uint32_t i = 0; i < 12; ++i) {
    out.m[i] = numbers->Get(i);
    if (!std::isfinite(out.m[i])) return false;
  }
  return true;
}

template <typename T, typename Elements>
Status decode(const format::Stream* stream, size_t elements_each, size_t count, Elements& out) {
  const auto stride = static_cast<uint32_t>(elements_each * sizeof(T));
  if (Status status = checkStream(stream, stride, count); !status.ok()) return status;
  out.resize(count * elements_each);
  return decodeStream(stream, stride, count, out.data());
}

}  // namespace

size_t textureLevelBytes(TextureFormat format, uint32_t width, uint32_t height, uint32_t level) {
  const size_t w = std::max(1u, width >> level);
  const size_t h = std::max(1u, height >> level);
  if (format == TextureFormat::kRgba8) return w * h * 4;
  const bool two_halves = format == TextureFormat::kBc5 || format == TextureFormat::kBc3;
  return ((w + 3) / 4) * ((h + 3) / 4) * (two_halves ? 16 : 8);
}

Asset::Asset() = default;
Asset::~Asset() = default;
Asset::Asset(Asset&&) noexcept = default;
Asset& Asset::operator=(Asset&&) noexcept = default;

namespace {

// Fills a Storage from a verified payload, checking every count, offset and index.
class Loader {
 public:
  Loader(Asset::Storage& storage, const format::Asset& asset) : s_(storage), a_(asset) {}

  Status load() {
    s_.tool_version = kept(a_.tool_version());
    s_.source_file = kept(a_.source());
    keep(a_.rig(), s_.rig);
    keep(a_.place_hash(), s_.place_hash);
    for (const auto step : {&Loader::loadParts, &Loader::loadColors, &Loader::loadPalette,
                            &Loader::loadPoints, &Loader::loadRest, &Loader::loadMorphs,
                            &Loader::loadTextures, &Loader::loadBaseMaps, &Loader::loadLayers})
      if (Status status = (this->*step)(); !status.ok()) return status;
    return {};
  }

 private:
  size_t vertices() const { return s_.positions.size(); }
  size_t triangles() const { return s_.indices.size() / 3; }
  size_t points() const { return s_.point_vertex.size(); }

  std::string_view kept(const flatbuffers::String* string) {
    if (!string || string->size() == 0) return {};
    const auto& name = s_.names.emplace_back(string->c_str(), string->c_str() + string->size() + 1);
    return {name.data(), string->size()};  // furrow.h hands it out with its 0
  }

  static void keep(const flatbuffers::Vector<uint8_t>* section, std::pmr::vector<std::byte>& out) {
    if (!section) return;
    const auto bytes = std::as_bytes(std::span(section->data(), section->size()));
    out.assign(bytes.begin(), bytes.end());
  }

  Status loadParts() {
    if (!a_.parts() || a_.parts()->size() == 0) return bad("it has no parts");
    if (a_.influences() == 0 || a_.influences() > 255) return bad("its number of influences is out of range");
    const size_t palette_size = a_.palette() ? a_.palette()->size() : 0;
    for (const format::Part* part : *a_.parts()) {
      PartGeometry geometry;
      if (Status status = decodePart(*part, a_.influences(), geometry); !status.ok()) return status;
      if (part->palette_begin() > palette_size ||
          part->palette_count() > palette_size - part->palette_begin())
        return bad("a part's palette is out of range");
      Part out = {};
      out.mesh = kept(part->mesh());
      out.material = kept(part->material());
      out.vertex_begin = static_cast<uint32_t>(vertices());
      out.triangle_begin = static_cast<uint32_t>(triangles());
      out.source_vertex_begin = out.vertex_begin;
      out.texture_set = part->texture_set();
      if (const format::Color* color = part->base_color())
        out.base_color = {color->r(), color->g(), color->b(), color->a()};
      if (!readAffine(part->rest(), out.rest)) return bad("a part's rest matrix is not sound");
      out.has_normals = part->has_normals();
      out.has_uvs = part->has_uvs();
      out.roughness = part->roughness();
      if (!(out.roughness >= 0.0f && out.roughness <= 1.0f)) return bad("a part's roughness is out of range");
      out.base_maps = part->base_maps();
      if (out.base_maps != kAbsent && (!a_.base_maps() || out.base_maps >= a_.base_maps()->size()))
        return bad("a part's own maps are out of range");
      out.position_offset = geometry.position_offset;
      out.position_step = geometry.position_step;
      append(geometry, out.vertex_begin, part->palette_begin());
      if (vertices() >= kAbsent || s_.indices.size() >= kAbsent) return bad("too many vertices");
      out.vertex_end = static_cast<uint32_t>(vertices());
      out.triangle_end = static_cast<uint32_t>(triangles());
      s_.parts.push_back(out);
    }
    return {};
  }

  void append(const PartGeometry& part, uint32_t first_vertex, uint32_t first_entry) {
    Asset::Storage& all = s_;
    all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
    all.normals.insert(all.normals.end(), part.normals.begin(), part.normals.end());
    all.tangents.insert(all.tangents.end(), part.tangents.begin(), part.tangents.end());
    all.uvs.insert(all.uvs.end(), part.uvs.begin(), part.uvs.end());
    all.weights.insert(all.weights.end(), part.weights.begin(), part.weights.end());
    for (uint16_t joint : part.joints) all.joints.push_back(static_cast<uint16_t>(joint + first_entry));
    for (uint32_t source : part.source) all.source.push_back(source + first_vertex);
    for (uint32_t index : part.indices) all.indices.push_back(index + first_vertex);
  }

  Status loadColors() {
    return streamCount(a_.colors()) == 0 ? Status() : decode<uint8_t>(a_.colors(), 4, vertices(), s_.colors);
  }

  Status loadPalette() {
    if (!a_.palette() || a_.palette()->size() > kMaxPaletteEntries)
      return bad("its palette is missing or too large");
    for (const format::PaletteEntry* entry : *a_.palette()) {
      PaletteEntry out = {kept(entry->node()), entry->node_index(), {}};
      if (!readAffine(entry->inverse_bind(), out.inverse_bind))
        return bad("an inverse bind matrix is not sound");
      s_.palette.push_back(out);
    }
    return {};
  }

  Status loadPoints() {
    if (a_.points() == 0 || a_.points() > vertices()) return bad("its number of points is out of range");
    if (Status status = decode<uint32_t>(a_.vertex_point(), 1, vertices(), s_.vertex_point); !status.ok())
      return status;
    s_.point_vertex.assign(a_.points(), kAbsent);
    for (uint32_t v = 0; v < vertices(); ++v) {
      if (s_.vertex_point[v] >= a_.points()) return bad("a point is out of range");
      if (s_.point_vertex[s_.vertex_point[v]] == kAbsent) s_.point_vertex[s_.vertex_point[v]] = v;
    }
    if (std::find(s_.point_vertex.begin(), s_.point_vertex.end(), kAbsent) != s_.point_vertex.end())
      return bad("a point has no vertex");
    s_.surface_indices.resize(s_.indices.size());
    for (size_t i = 0; i < s_.surface_indices.size(); ++i)
      s_.surface_indices[i] = s_.point_vertex[s_.vertex_point[s_.indices[i]]];

    if (!(a_.place_error() >= 0.0f) || !std::isfinite(a_.place_error()))
      return bad("the error of its places is out of range");
    const size_t places = streamCount(a_.place_points());
    if (Status status = decode<uint32_t>(a_.place_points(), 2, places, s_.place_points); !status.ok())
      return status;
    for (size_t i = 0; i < places; ++i)
      if (s_.place_points[2 * i] >= points() || s_.place_points[2 * i + 1] == 0 ||
          s_.place_points[2 * i + 1] > points() - s_.place_points[2 * i])
        return bad("a place's points are out of range");
    return {};
  }

  // Where the points rest, and what follows from that.
  Status loadRest() {
    if (streamCount(a_.rest()) > 0) {
      rest_points_.resize(points());
      if (Status status = decodeStream(a_.rest(), sizeof(Float3), points(), rest_points_.data());
          !status.ok())
        return status;
    } else {
      rest_points_.reserve(points());
      auto part = s_.parts.begin();
      for (uint32_t v : s_.point_vertex) {
        if (v < part->vertex_begin || v >= part->vertex_end)
          part = std::upper_bound(s_.parts.begin(), s_.parts.end(), v,
                                  [](uint32_t vertex, const Part& each) { return vertex < each.vertex_end; });
        rest_points_.push_back(transformed(part->rest, s_.positions[v]));
      }
    }
    for (const Float3& p : rest_points_)
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        return bad("a point rests nowhere");
    const Rings rings = makeRings(restSurface());
    s_.ring_offsets.assign(rings.offsets.begin(), rings.offsets.end());
    s_.ring_triangles.assign(rings.triangles.begin(), rings.triangles.end());
    s_.ring_weights.assign(rings.weights.begin(), rings.weights.end());
    point_normals_ = pointNormals(restSurface());
    return {};
  }

  RestSurface restSurface() const { return {rest_points_, s_.indices, s_.vertex_point}; }

  Status loadMorphs() {
    if (!a_.morphs() || a_.morphs()->size() == 0) return {};
    if (a_.morphs()->size() > 65535) return bad("too many morph targets");
    std::vector<uint32_t> surface_vertex(vertices());
    for (size_t v = 0; v < vertices(); ++v) surface_vertex[v] = s_.point_vertex[s_.vertex_point[v]];
    const MorphPredictor predictor(s_.indices, surface_vertex);
    std::vector<Int3> field(vertices()), deltas;
    std::vector<uint32_t> moved;
    for (const format::Morph* morph : *a_.morphs()) {
      Morph out = {kept(morph->name()),
                   morph->default_weight(),
                   morph->position_step(),
                   morph->normal_step(),
                   {},
                   {},
                   {}};
      if (!std::isfinite(out.default_weight) || !std::isfinite(out.position_step) ||
          !std::isfinite(out.normal_step))
        return bad("a morph target's numbers are not finite");
      if (Status status = decodeRuns(morph->runs(), vertices(), moved); !status.ok()) return status;
      const auto& ids = s_.words.emplace_back(moved.begin(), moved.end());
      if (Status status = decodeDeltas(morph->positions(), kPositionDeltaBits, predictor, ids, field, deltas);
          !status.ok())
        return status;
      auto& positions = s_.integers.emplace_back();
      positions.reserve(3 * ids.size());
      for (const Int3& d : deltas) positions.insert(positions.end(), d.begin(), d.end());
      out.vertices = ids;
      out.position_deltas = positions;
      if (streamCount(morph->normals()) > 0) {
        if (Status status = decodeDeltas(morph->normals(), kNormalDeltaBits, predictor, ids, field, deltas);
            !status.ok())
          return status;
        auto& normals = s_.bytes.emplace_back();
        normals.reserve(3 * ids.size());
        for (const Int3& d : deltas)
          for (int32_t each : d) normals.push_back(static_cast<int8_t>(each));
        out.normal_deltas = normals;
      }
      s_.morphs.push_back(out);
    }
    gatherMorphs();
    return {};
  }

  void gatherMorphs() {
    if (s_.morphs.empty()) return;
    auto& words = s_.morph_entries;
    words.assign(vertices() + 1, 0);
    size_t entries = 0;
    for (const Morph& morph : s_.morphs) {
      for (uint32_t vertex : morph.vertices) ++words[vertex + 1];
      entries += morph.vertices.size();
    }
    for (size_t v = 0; v < vertices(); ++v) words[v + 1] += words[v];
    std::vector<uint32_t> next(words.begin(), words.end() - 1);
    words.resize(vertices() + 1 + 4 * entries);
    for (size_t m = 0; m < s_.morphs.size(); ++m) {
      const Morph& morph = s_.morphs[m];
      for (size_t i = 0; i < morph.vertices.size(); ++i) {
        uint32_t* entry = &words[vertices() + 1 + 4 * size_t{next[morph.vertices[i]]++}];
        for (size_t c = 0; c < 3; ++c) {
          const auto normal = morph.normal_deltas.empty() ? int8_t{0} : morph.normal_deltas[3 * i + c];
          entry[c] = (static_cast<uint32_t>(morph.position_deltas[3 * i + c]) & 0xffffffu) |
                     uint32_t{static_cast<uint8_t>(normal)} << 24;
        }
        entry[3] = static_cast<uint32_t>(m);
      }
    }
  }

  Status loadTexture(const format::Texture* texture, TextureFormat format, Texture& out) {
    out = {format, 0, 0, 0, 0, {}};
    if (!texture || texture->slices() == 0) return {};
    const uint32_t w = texture->width();
    const uint32_t h = texture->height();
    if (texture->format() != static_cast<uint8_t>(format) || w == 0 || h == 0 || w > 16384 || h > 16384 ||
        texture->slices() > 2 * kMaxLayers || texture->levels() == 0 ||
        texture->levels() > static_cast<uint32_t>(std::bit_width(std::max(w, h))))
      return bad("a texture's size or format is out of range");
    size_t bytes = 0;
    for (uint32_t level = 0; level < texture->levels(); ++level)
      bytes += textureLevelBytes(format, w, h, level) * texture->slices();
    auto& texels = s_.texels.emplace_back();
    const size_t unit = textureLevelBytes(format, 1, 1, 0);  // a texel or a block
    if (Status status = decode<std::byte>(texture->stream(), unit, bytes / unit, texels); !status.ok())
      return status;
    out = {format,
           w,
           h,
           texture->slices(),
           texture->levels(),
           texels,
           texture->rms_error(),
           texture->largest_error()};
    return {};
  }

  Status loadTextures() {
    const uint32_t layers = a_.layers() ? a_.layers()->size() : 0;
    if (layers == 0 || layers > kMaxLayers) return bad("its number of layers is out of range");
    for (size_t i = 0; a_.texture_sets() && i < a_.texture_sets()->size(); ++i) {
      const format::TextureSet* set = a_.texture_sets()->Get(static_cast<uint32_t>(i));
      TextureSet out = {};
      out.name = kept(set->name());
      if (Status status = loadTexture(set->normals(), TextureFormat::kBc5, out.normals); !status.ok())
        return status;
      if (Status status = loadTexture(set->shading(), TextureFormat::kBc4, out.shading); !status.ok())
        return status;
      if (Status status = loadTexture(set->masks(), TextureFormat::kRgba8, out.masks); !status.ok())
        return status;
      if (out.shading.slices != out.normals.slices) return bad("normal and shading maps differ in number");
      if (out.masks.slices != 0 && out.masks.slices != (layers + 3) / 4)
        return bad("mask textures differ from the layers in number");
      if (!set->compress_slice() || !set->stretch_slice() || set->compress_slice()->size() != layers ||
          set->stretch_slice()->size() != layers)
        return bad("a texture set names too few slices");
      std::fill(std::begin(out.compress_slice), std::end(out.compress_slice), kAbsent);
      std::fill(std::begin(out.stretch_slice), std::end(out.stretch_slice), kAbsent);
      for (uint32_t l = 0; l < layers; ++l) {
        out.compress_slice[l] = set->compress_slice()->Get(l);
        out.stretch_slice[l] = set->stretch_slice()->Get(l);
        for (uint32_t slice : {out.compress_slice[l], out.stretch_slice[l]})
          if (slice != kAbsent && slice >= out.normals.slices) return bad("a layer's map is out of range");
      }
      std::fill(std::begin(out.windows), std::end(out.windows), Float4{0.0f, 0.0f, 1.0f, 1.0f});
      if (set->windows()) {
        if (set->windows()->size() != 4 * out.normals.slices) return bad("a texture set has too few windows");
        for (uint32_t slice = 0; slice < out.normals.slices; ++slice) {
          const float* w = set->windows()->data() + 4 * slice;
          for (int c = 0; c < 4; ++c)
            if (!(w[c] >= (c < 2 ? 0.0f : 1.0f)) || !(w[c] <= (c < 2 ? 1.0f : 1e6f)))
              return bad("a map's window is out of range");
          out.windows[slice] = {w[0], w[1], w[2], w[3]};
        }
      }
      s_.texture_sets.push_back(out);
    }
    for (const Part& part : s_.parts)
      if (part.texture_set != kAbsent && part.texture_set >= s_.texture_sets.size())
        return bad("a part's texture set is out of range");
    return {};
  }

  Status loadBaseMaps() {
    for (uint32_t i = 0; a_.base_maps() && i < a_.base_maps()->size(); ++i) {
      const format::BaseMaps* maps = a_.base_maps()->Get(i);
      BaseMaps out = {};
      const bool with_opacity =
          maps->color() && maps->color()->format() == static_cast<uint8_t>(TextureFormat::kBc3);
      if (Status status =
              loadTexture(maps->color(), with_opacity ? TextureFormat::kBc3 : TextureFormat::kBc1, out.color);
          !status.ok())
        return status;
      if (Status status = loadTexture(maps->normal(), TextureFormat::kBc5, out.normal); !status.ok())
        return status;
      out.opaque_from = maps->opaque_from();
      const format::Wrap wraps[] = {maps->color_wrap_u(), maps->color_wrap_v(), maps->normal_wrap_u(),
                                    maps->normal_wrap_v()};
      for (size_t w = 0; w < 4; ++w) {
        if (wraps[w] > format::Wrap::Mirror)
          return bad("a map continues in an unknown way beyond its borders");
        (w < 2 ? out.color_wrap : out.normal_wrap)[w % 2] = static_cast<Wrap>(wraps[w]);
      }
      if (out.color.slices > 1 || out.normal.slices > 1 || !readUv(maps->color_uv(), out.color_uv) ||
          !readUv(maps->normal_uv(), out.normal_uv) || !(out.opaque_from >= 0.0f && out.opaque_from <= 1.0f))
        return bad("the model's own maps are not sound");
      s_.base_maps.push_back(out);
    }
    return {};
  }

  static bool readUv(const flatbuffers::Vector<float>* numbers, float (&out)[6]) {
    out[0] = out[3] = 1.0f;
    if (!numbers) return true;
    if (numbers->size() != 6) return false;
    std::copy_n(numbers->data(), 6, out);
    return std::all_of(out, out + 6, [](float n) { return std::isfinite(n); });
  }

  Status loadLayers() {
    for (const format::Layer* layer : *a_.layers()) {
      if (layer->measure() > static_cast<uint8_t>(Measure::kNone) ||
          layer->curve() > static_cast<uint8_t>(Curve::kOat))
        return bad("a layer has an unknown measure or curve");
      Layer out = {};
      out.name = kept(layer->name());
      out.measure = static_cast<Measure>(layer->measure());
      out.response = {static_cast<Curve>(layer->curve()), layer->lambda(), layer->beta(),
                      layer->stretch_lambda(), layer->stretch_beta()};
      for (float value : {layer->lambda(), layer->beta(), layer->stretch_lambda(), layer->stretch_beta()})
        if (!(value > 0.0f) || !std::isfinite(value)) return bad("a layer's response is out of range");
      if (Status status = loadLayerStreams(*layer, out); !status.ok()) return status;
      out.mask_slice = layer->mask_slice();
      out.driver_begin = static_cast<uint32_t>(s_.drivers.size());
      for (size_t i = 0; layer->drivers() && i < layer->drivers()->size(); ++i) {
        const format::Driver* driver = layer->drivers()->Get(static_cast<uint32_t>(i));
        if (driver->morph() >= s_.morphs.size() || !std::isfinite(driver->gain()))
          return bad("a driver is out of range");
        s_.drivers.push_back({driver->morph(), driver->gain(), {}});
        if (!driver->curve() || driver->curve()->size() == 0) continue;
        if (driver->curve()->size() % 2 != 0) return bad("a driver's curve is not sound");
        auto& curve = s_.curves.emplace_back();
        for (uint32_t c = 0; c < driver->curve()->size(); c += 2) {
          curve.push_back({driver->curve()->Get(c), driver->curve()->Get(c + 1)});
          if (!std::isfinite(curve.back().x) || !std::isfinite(curve.back().y) ||
              (c > 0 && !(curve[curve.size() - 2].x < curve.back().x)))
            return bad("a driver's curve is not sound");
        }
        s_.drivers.back().curve = curve;
      }
      out.driver_end = static_cast<uint32_t>(s_.drivers.size());
      if (out.mask_slice != kAbsent && out.mask_slice / 4 >= (a_.layers()->size() + 3) / 4)
        return bad("a layer's mask is out of range");
      s_.layers.push_back(out);
    }
    return {};
  }

  Status loadLayerStreams(const format::Layer& layer, Layer& out) {
    std::vector<Float3> directions;
    std::vector<PackedDirection> packed;
    if (const auto* axis = layer.axis()) {
      const Float3 along = axis->size() == 3 ? Float3{axis->Get(0), axis->Get(1), axis->Get(2)} : Float3{};
      const float size = std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
      if (!(size > 0.0f) || !std::isfinite(size)) return bad("a layer's axis is not sound");
      std::vector<Float3> projected;
      std::vector<float> confidence;
      projectAxis(point_normals_, along, projected, confidence);
      packed = packDirections(point_normals_, projected, confidence);
    } else if (streamCount(layer.directions()) > 0) {
      packed.resize(points());
      if (Status status = decodeStream(layer.directions(), sizeof(PackedDirection), points(), packed.data());
          !status.ok())
        return status;
    }
    if (!packed.empty()) {
      directions = unpackDirections(point_normals_, packed);
      auto& bytes = s_.bytes.emplace_back();
      bytes.reserve(4 * points());
      for (size_t p = 0; p < points(); ++p) {
        for (float c : {directions[p].x, directions[p].y, directions[p].z})
          bytes.push_back(static_cast<int8_t>(std::lround(c * 127.0f)));
        bytes.push_back(static_cast<int8_t>(std::min<uint8_t>(packed[p].confidence, 127)));
      }
      out.directions = bytes;
    } else if (out.measure == Measure::kDirectional) {
      return bad("a directional layer has no directions");
    }
    if (const uint32_t each = coefficientCount(out.measure); each > 0) {
      auto& coefficients = s_.floats.emplace_back(each * triangles(), 0.0f);
      const auto cover = [&](const Part& part) {
        makeCoefficients(restSurface(), out.measure, directions, part.triangle_begin, part.triangle_end,
                         coefficients);
      };
      if (!layer.parts()) std::for_each(s_.parts.begin(), s_.parts.end(), cover);
      for (uint32_t i = 0; layer.parts() && i < layer.parts()->size(); ++i) {
        const uint32_t part = layer.parts()->Get(i);
        if (part >= s_.parts.size() || (i > 0 && part <= layer.parts()->Get(i - 1)))
          return bad("a layer's part is out of range");
        cover(s_.parts[part]);
      }
      out.coefficients = coefficients;
    }
    if (streamCount(layer.bias()) > 0) {
      auto& bias = s_.shorts.emplace_back();
      if (Status status = decode<int16_t>(layer.bias(), 2, (vertices() + 1) / 2, bias); !status.ok())
        return status;
      out.bias = std::span(bias).first(vertices());
    }
    if (streamCount(layer.mask()) > 0) {
      auto& mask = s_.bytes.emplace_back();
      if (Status status = decode<int8_t>(layer.mask(), 4, (vertices() + 3) / 4, mask); !status.ok())
        return status;
      out.mask = {reinterpret_cast<const uint8_t*>(mask.data()), vertices()};
    }
    return {};
  }

  Asset::Storage& s_;
  const format::Asset& a_;
  std::vector<Float3> rest_points_, point_normals_;
};

Status checkHeader(std::span<const std::byte> file, AssetHeader& header) {
  if (file.size() < sizeof header) return bad("it is shorter than the header of a furrow asset");
  std::memcpy(&header, file.data(), sizeof header);
  if (std::memcmp(header.magic, kAssetMagic, sizeof header.magic) != 0)
    return bad("it is not a furrow asset");
  if (header.version != kFormatVersion)
    return Status::error(StatusCode::kUnsupportedVersion,
                         "it has format version %u, this furrow reads version %u", header.version,
                         kFormatVersion);
  if (header.reserved != 0 || header.payload_bytes != file.size() - sizeof header)
    return bad("it is cut short or has bytes at its end");
  const std::span<const std::byte> payload = file.subspan(sizeof header);
  if (XXH3_64bits_withSeed(payload.data(), payload.size(), header.version) != header.payload_hash)
    return bad("its checksum is wrong, a byte was changed");
  return {};
}

}  // namespace

Status Asset::load(std::span<const std::byte> file, std::pmr::memory_resource* memory) try {
  view_ = {};
  storage_.reset();
  AssetHeader header;
  if (Status status = checkHeader(file, header); !status.ok()) return status;
  std::unique_ptr<Storage, Free> storage(
      std::pmr::polymorphic_allocator<>(memory).new_object<Storage>(memory));
  const std::vector<std::byte> payload(file.begin() + sizeof header, file.end());  // aligned
  const auto* bytes = reinterpret_cast<const uint8_t*>(payload.data());
  flatbuffers::Verifier verifier(bytes, payload.size());
  if (!format::VerifyAssetBuffer(verifier)) return bad("its tables are not sound");
  const format::Asset& asset = *format::GetAsset(bytes);
  if (Status status = Loader(*storage, asset).load(); !status.ok()) return status;

  Storage& s = *storage;
  view_ = {s.positions,
           s.normals,
           s.tangents,
           s.uvs,
           s.source,
           s.vertex_point,
           asset.influences(),
           s.joints,
           s.weights,
           s.indices,
           s.surface_indices,
           s.point_vertex,
           s.ring_offsets,
           s.ring_triangles,
           s.ring_weights,
           s.morph_entries,
           s.parts,
           s.palette,
           s.morphs,
           s.layers,
           s.drivers,
           s.texture_sets,
           s.tool_version,
           s.source_file,
           s.rig,
           s.place_hash,
           s.place_points,
           asset.position_error(),
           asset.morph_error(),
           s.colors,
           s.base_maps,
           asset.place_error()};
  storage_ = std::move(storage);
  return {};
} catch (const std::bad_alloc&) {
  return Status::error(StatusCode::kOutOfMemory, "out of memory");
}

}  // namespace furrow

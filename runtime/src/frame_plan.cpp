#include "furrow/frame_plan.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "shader_text.h"
#include "shaders/layout.h"

namespace furrow {
namespace {

static_assert(gpu::kLayerLimit == kMaxLayers);
static_assert(gpu::kMeasurePrincipal == static_cast<uint32_t>(Measure::kPrincipal) &&
              gpu::kCurveOat == static_cast<uint32_t>(Curve::kOat));

constexpr Binding kFrameBinding = {0, Buffer::kFrame, Access::kUniform, "frame_block"};

constexpr Binding storage(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kStorage, name};
}
constexpr Binding floats(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kFloats, name};
}
constexpr Binding words(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kWords, name};
}
constexpr Binding capture(uint32_t slot, Buffer buffer) {
  return {slot, buffer, Access::kCapture, nullptr};
}

constexpr Binding kDeformBindings[] = {kFrameBinding,
                                       storage(0, Buffer::kRestVertices, "rest_vertices"),
                                       storage(1, Buffer::kInfluences, "influences"),
                                       storage(2, Buffer::kMorphEntries, "morph_entries"),
                                       storage(3, Buffer::kPalette, "palette"),
                                       storage(4, Buffer::kMorphWeights, "morph_weights"),
                                       storage(5, Buffer::kPositions, "positions"),
                                       storage(6, Buffer::kNormals, "normals"),
                                       storage(7, Buffer::kTangents, "tangents")};
constexpr Binding kCompressBindings[] = {
    kFrameBinding, storage(0, Buffer::kSurfaceIndices, "surface_indices"),
    storage(1, Buffer::kCoefficients, "coefficients"), storage(2, Buffer::kPositions, "positions"),
    storage(3, Buffer::kTriangleQ, "triangle_q")};
constexpr Binding kSmoothBindings[] = {kFrameBinding,
                                       storage(0, Buffer::kRingOffsets, "ring_offsets"),
                                       storage(1, Buffer::kRingTriangles, "ring_triangles"),
                                       storage(2, Buffer::kRingWeights, "ring_weights"),
                                       storage(3, Buffer::kTriangleQ, "triangle_q"),
                                       storage(4, Buffer::kPointQ, "point_q")};
constexpr Binding kRespondBindings[] = {
    kFrameBinding, storage(0, Buffer::kVertexPoint, "vertex_point"), storage(1, Buffer::kBias, "bias"),
    storage(2, Buffer::kPointQ, "point_q"), storage(3, Buffer::kWeights, "weights")};

constexpr Binding kRasterDeformBindings[] = {kFrameBinding,
                                             floats(0, Buffer::kRestVertices, "rest_vertices"),
                                             words(1, Buffer::kInfluences, "influences"),
                                             words(2, Buffer::kMorphEntries, "morph_entries"),
                                             floats(3, Buffer::kPalette, "palette"),
                                             floats(4, Buffer::kMorphWeights, "morph_weights"),
                                             capture(0, Buffer::kPositions),
                                             capture(1, Buffer::kNormals),
                                             capture(2, Buffer::kTangents)};
constexpr Binding kRasterMeasureBindings[] = {kFrameBinding,
                                              floats(0, Buffer::kPositions, "positions"),
                                              words(1, Buffer::kVertexPoint, "vertex_point"),
                                              floats(2, Buffer::kMeasured, "measured"),
                                              {0, Buffer::kSurfaceIndices, Access::kIndices, nullptr}};
constexpr Binding kRasterRespondBindings[] = {kFrameBinding,
                                              words(0, Buffer::kVertexPoint, "vertex_point"),
                                              words(1, Buffer::kBias, "bias"),
                                              {2, Buffer::kCount, Access::kSums, "sums"},
                                              capture(0, Buffer::kWeights)};

constexpr const char* kPosedOutputs[] = {"posed_position", "posed_normal", "posed_tangent"};
constexpr const char* kPairOutputs[] = {"pair0", "pair1", "pair2", "pair3",
                                        "pair4", "pair5", "pair6", "pair7"};
static_assert(std::size(kPairOutputs) * 2 == kMaxLayers);

uint32_t word(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

std::vector<uint32_t> restVertexWords(const AssetView& asset) {
  std::vector<uint32_t> words;
  words.reserve(size_t{asset.vertexCount()} * gpu::kRestVertexWords);
  for (uint32_t v = 0; v < asset.vertexCount(); ++v) {
    const Float3 p = asset.positions[v];
    const Float3 n = asset.normals[v];
    const Float4 t = asset.tangents[v];
    for (float value : {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, t.z, t.w}) words.push_back(word(value));
  }
  return words;
}

std::vector<uint32_t> influenceWords(const AssetView& asset) {
  std::vector<uint32_t> words(asset.joints.size());
  for (size_t i = 0; i < words.size(); ++i)
    words[i] = asset.joints[i] | static_cast<uint32_t>(asset.weights[i]) << 16;
  return words;
}

std::vector<uint32_t> coefficientWords(const AssetView& asset) {
  std::vector<uint32_t> words;
  for (const Layer& layer : asset.layers)
    for (float value : layer.coefficients) words.push_back(word(value));
  return words;
}

std::vector<uint32_t> ringWeightWords(const AssetView& asset) {
  std::vector<uint32_t> words((asset.ring_weights.size() + 1) / 2);
  std::memcpy(words.data(), asset.ring_weights.data(), asset.ring_weights.size_bytes());
  return words;
}

bool hasBias(const AssetView& asset) {
  for (const Layer& layer : asset.layers)
    if (!layer.bias.empty()) return true;
  return false;
}

std::vector<uint32_t> biasWords(const AssetView& asset) {
  const size_t stride = asset.weightStride();
  std::vector<uint32_t> words(asset.vertexCount() * stride / 2);
  auto* values = reinterpret_cast<int16_t*>(words.data());
  for (size_t l = 0; l < asset.layers.size(); ++l)
    for (size_t v = 0; v < asset.layers[l].bias.size(); ++v) values[v * stride + l] = asset.layers[l].bias[v];
  return words;
}

// A triangle: bit l says that layer l measures it.
std::vector<uint32_t> measuringLayers(const AssetView& asset) {
  std::vector<uint32_t> bits(asset.triangleCount());
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    const uint32_t each = coefficientCount(asset.layers[l].measure);
    for (uint32_t t = 0; t < asset.triangleCount(); ++t)
      for (float value : asset.layers[l].coefficients.subspan(size_t{t} * each, each))
        if (value != 0.0f) bits[t] |= 1u << l;
  }
  return bits;
}

// Rest angles by corner, as in the rings; 0 for a triangle that is in none.
std::vector<uint16_t> cornerAngles(const AssetView& asset) {
  std::vector<uint16_t> angles(asset.indices.size());
  for (uint32_t p = 0; p < asset.pointCount(); ++p)
    for (uint32_t i = asset.ring_offsets[p]; i < asset.ring_offsets[p + 1]; ++i)
      for (size_t c = 0; c < 3; ++c) {
        const size_t corner = 3 * size_t{asset.ring_triangles[i]} + c;
        if (asset.vertex_point[asset.surface_indices[corner]] == p) angles[corner] = asset.ring_weights[i];
      }
  return angles;
}

}  // namespace

BufferDesc& FramePlan::add(Buffer id, const char* name, Lifetime lifetime, uint64_t bytes) {
  return buffers_[static_cast<size_t>(id)] = {name, lifetime, bytes, {}};
}

void FramePlan::fill(Buffer id, const char* name, std::span<const std::byte> initial) {
  add(id, name, Lifetime::kPerAsset, initial.size()).initial = initial;
}

void FramePlan::fillWords(Buffer id, const char* name, std::vector<uint32_t> words) {
  words_.push_back(std::move(words));
  fill(id, name, std::as_bytes(std::span(words_.back())));
}

FramePlan::FramePlan(const AssetView& asset, const PlanOptions& options) : asset_(&asset), options_(options) {
  words_.reserve(static_cast<size_t>(Buffer::kCount));
  addCommon();
  if (options.form == Form::kStaged)
    addStaged();
  else
    addRaster();
}

void FramePlan::addCommon() {
  const AssetView& asset = *asset_;
  const uint64_t vertices = asset.vertexCount();
  fill(Buffer::kVertexPoint, "furrow vertex points", std::as_bytes(asset.vertex_point));
  if (hasBias(asset)) fillWords(Buffer::kBias, "furrow bias", biasWords(asset));
  add(Buffer::kFrame, "furrow frame", Lifetime::kPerInstance, sizeof(gpu::FrameConstants));
  add(Buffer::kPositions, "furrow posed positions", Lifetime::kPerInstance, vertices * sizeof(Float3));
  add(Buffer::kWeights, "furrow weights", Lifetime::kPerInstance,
      vertices * asset.weightStride() * sizeof(int16_t));
  if (options_.posed_by_host) return;
  fillWords(Buffer::kRestVertices, "furrow rest vertices", restVertexWords(asset));
  fillWords(Buffer::kInfluences, "furrow influences", influenceWords(asset));
  fill(Buffer::kMorphEntries, "furrow morph entries", std::as_bytes(asset.morph_entries));
  add(Buffer::kPalette, "furrow palette", Lifetime::kPerInstance, asset.palette.size() * sizeof(Affine));
  add(Buffer::kMorphWeights, "furrow morph weights", Lifetime::kPerInstance,
      asset.morphs.size() * sizeof(Float2));
  if (!options_.normals) return;
  add(Buffer::kNormals, "furrow posed normals", Lifetime::kPerInstance, vertices * sizeof(Float3));
  add(Buffer::kTangents, "furrow posed tangents", Lifetime::kPerInstance, vertices * sizeof(Float4));
}

void FramePlan::addStaged() {
  const AssetView& asset = *asset_;
  const uint64_t layers = asset.layerCount();
  fill(Buffer::kSurfaceIndices, "furrow surface indices", std::as_bytes(asset.surface_indices));
  fillWords(Buffer::kCoefficients, "furrow coefficients", coefficientWords(asset));
  fill(Buffer::kRingOffsets, "furrow ring offsets", std::as_bytes(asset.ring_offsets));
  fill(Buffer::kRingTriangles, "furrow ring triangles", std::as_bytes(asset.ring_triangles));
  fillWords(Buffer::kRingWeights, "furrow ring weights", ringWeightWords(asset));
  add(Buffer::kTriangleQ, "furrow triangle q", Lifetime::kPerInstance,
      asset.triangleCount() * layers * sizeof(float));
  add(Buffer::kPointQ, "furrow point q", Lifetime::kPerInstance, asset.pointCount() * layers * sizeof(float));

  const auto dispatch = [&](const char* label, Shader shader, uint32_t count,
                            std::span<const Binding> bindings) {
    constexpr uint32_t kMaxGroups = 65535;  // in one dimension, as OpenGL and Vulkan guarantee
    const uint32_t groups = (count + gpu::kGroupSize - 1) / gpu::kGroupSize;
    const uint32_t rows = (groups + kMaxGroups - 1) / kMaxGroups;
    items_.push_back({.kind = ItemKind::kDispatch,
                      .label = label,
                      .shader = shader,
                      .groups = {rows ? (groups + rows - 1) / rows : 0, rows},
                      .bindings = bindings});
    items_.push_back({.kind = ItemKind::kBarrier, .label = label});
  };
  if (!options_.posed_by_host)
    dispatch("furrow deform", Shader::kDeform, asset.vertexCount(), kDeformBindings);
  dispatch("furrow compress", Shader::kCompress, asset.triangleCount(), kCompressBindings);
  dispatch("furrow smooth", Shader::kSmooth, asset.pointCount(), kSmoothBindings);
  dispatch("furrow respond", Shader::kRespond, asset.vertexCount(), kRespondBindings);
}

void FramePlan::addRaster() {
  const AssetView& asset = *asset_;
  if (!options_.posed_by_host) {
    const size_t outputs = options_.normals ? 3 : 1;
    items_.push_back(
        {.kind = ItemKind::kDraw,
         .label = "furrow deform",
         .shader = Shader::kRasterDeform,
         .count = asset.vertexCount(),
         .bindings = std::span(kRasterDeformBindings).first(std::size(kRasterDeformBindings) - 3 + outputs),
         .captured = std::span(kPosedOutputs).first(outputs)});
    items_.push_back({.kind = ItemKind::kBarrier, .label = "furrow deform"});
  }
  addSlices();
  items_.push_back({.kind = ItemKind::kBarrier, .label = "furrow measure"});
  items_.push_back({.kind = ItemKind::kDraw,
                    .label = "furrow respond",
                    .shader = Shader::kRasterRespond,
                    .count = asset.vertexCount(),
                    .bindings = kRasterRespondBindings,
                    .captured = std::span(kPairOutputs).first(asset.weightStride() / 2)});
  items_.push_back({.kind = ItemKind::kBarrier, .label = "furrow respond"});
}

void FramePlan::addSlices() {
  const AssetView& asset = *asset_;
  const std::vector<uint16_t> angles = cornerAngles(asset);
  const std::vector<uint32_t> measuring = measuringLayers(asset);
  std::vector<uint32_t> indices, measured;
  uint32_t done = 0;  // bit l: layer l has its slice
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    std::vector<uint32_t> triangles;
    for (uint32_t t = 0; t < asset.triangleCount(); ++t)
      if (measuring[t] >> l & 1u) triangles.push_back(t);
    if (done >> l & 1u || triangles.empty()) continue;
    Slice slice = {{kAbsent, kAbsent, kAbsent}, static_cast<uint32_t>(measured.size()), 3};
    uint32_t count = 0;
    for (uint32_t other = l; other < asset.layerCount() && count < gpu::kLayersASlice; ++other) {
      const bool same = std::all_of(measuring.begin(), measuring.end(),
                                    [&](uint32_t bits) { return (bits >> l & 1u) == (bits >> other & 1u); });
      if (done >> other & 1u || !same) continue;
      done |= 1u << other;
      slice.layers[count++] = other;
      slice.record_words += coefficientCount(asset.layers[other].measure);
    }
    const auto index = static_cast<uint32_t>(slices_.size());
    items_.push_back({.kind = ItemKind::kClear, .label = "furrow clear sums", .slice = index});
    items_.push_back({.kind = ItemKind::kDraw,
                      .label = "furrow measure",
                      .shader = Shader::kRasterMeasure,
                      .first = static_cast<uint32_t>(indices.size()),
                      .count = static_cast<uint32_t>(3 * triangles.size()),
                      .slice = index,
                      .bindings = kRasterMeasureBindings});
    for (uint32_t t : triangles) {
      for (size_t c = 0; c < 3; ++c) {
        indices.push_back(asset.surface_indices[3 * size_t{t} + c]);
        measured.push_back(word(static_cast<float>(angles[3 * size_t{t} + c])));
      }
      for (uint32_t c = 0; c < count; ++c) {
        const Layer& layer = asset.layers[slice.layers[c]];
        const uint32_t each = coefficientCount(layer.measure);
        for (float value : layer.coefficients.subspan(size_t{t} * each, each))
          measured.push_back(word(value));
      }
    }
    slices_.push_back(slice);
  }
  fillWords(Buffer::kSurfaceIndices, "furrow measured corners", std::move(indices));
  fillWords(Buffer::kMeasured, "furrow measured triangles", std::move(measured));
  sums_ = {gpu::kSumsWidth, (asset.pointCount() + gpu::kSumsWidth - 1) / gpu::kSumsWidth,
           static_cast<uint32_t>(slices_.size())};
}

void FramePlan::writeFrame(const FrameInput& input, std::span<std::byte> out) const {
  const AssetView& asset = *asset_;
  gpu::FrameConstants frame = {};
  frame.vertices = asset.vertexCount();
  frame.triangles = asset.triangleCount();
  frame.points = asset.pointCount();
  frame.layers = asset.layerCount();
  frame.influences = asset.influences;
  frame.morphs = static_cast<uint32_t>(asset.morphs.size());
  frame.with_normals = options_.normals;
  frame.with_bias = buffer(Buffer::kBias).bytes > 0;
  frame.inverse_scale2 = 1.0f / (input.scale * input.scale);
  frame.sums_height = sums_.height;
  uint32_t first = 0;
  for (uint32_t l = 0; l < frame.layers; ++l) {
    const Layer& layer = asset.layers[l];
    const Response& response = input.responses.empty() ? layer.response : input.responses[l];
    gpu::LayerConstants& to = frame.layer[l];
    to.lambda = response.lambda;
    to.beta = response.beta;
    to.stretch_lambda = response.stretch_lambda;
    to.stretch_beta = response.stretch_beta;
    to.measure = static_cast<uint32_t>(layer.measure);
    to.curve = static_cast<uint32_t>(response.curve);
    to.first_coefficient = first;
    to.region = input.region_weights.empty() ? 0.0f : input.region_weights[l];
    to.slice = gpu::kNoLayer;
    first += static_cast<uint32_t>(layer.coefficients.size());
  }
  for (uint32_t s = 0; s < slices_.size(); ++s) {
    const Slice& slice = slices_[s];
    frame.slice[s] = {
        slice.layers[0], slice.layers[1], slice.layers[2], slice.first_word, slice.record_words, 0, 0, 0};
    for (uint32_t c = 0; c < gpu::kLayersASlice && slice.layers[c] != kAbsent; ++c) {
      frame.layer[slice.layers[c]].slice = s;
      frame.layer[slice.layers[c]].channel = c;
    }
  }
  if (out.size() >= sizeof frame) std::memcpy(out.data(), &frame, sizeof frame);
}

void FramePlan::writeMorphWeights(const FrameInput& input, std::span<std::byte> out) const {
  const std::span<const Morph> morphs = asset_->morphs;
  for (size_t m = 0; m < morphs.size() && (m + 1) * sizeof(Float2) <= out.size(); ++m) {
    const Float2 steps = {input.morph_weights[m] * morphs[m].position_step,
                          input.morph_weights[m] * morphs[m].normal_step};
    std::memcpy(out.data() + m * sizeof steps, &steps, sizeof steps);
  }
}

const ShaderSource& shaderSource(Shader shader) {
  using namespace shader_text;
  constexpr size_t kShaders = static_cast<size_t>(Shader::kCount);
  static const std::array<std::array<std::string, 3>, kShaders> texts = [] {
    const std::string compute = std::string("#version 430\n") + kLayout + kPrelude;
    const std::string raster =
        std::string("#version 330 core\n#extension GL_ARB_gpu_shader5 : enable\n") + kLayout + kPreludeRaster;
    return std::array<std::array<std::string, 3>, kShaders>{
        {{compute + kNumbers + kPose + kDeform},
         {compute + kMeasure + kCompress},
         {compute + kSmooth},
         {compute + kNumbers + kResponse + kRespond},
         {raster + kNumbers + kPose + kRasterDeform},
         {raster + kRasterCorners, raster + kMeasure + kRasterMeasure, raster + kRasterSum},
         {raster + kNumbers + kResponse + kRasterRespond}}};
  }();
  static const std::array<ShaderSource, kShaders> sources = [] {
    std::array<ShaderSource, kShaders> all;
    for (size_t i = 0; i < kShaders; ++i) {
      const bool raster = i >= static_cast<size_t>(Shader::kRasterDeform);
      (raster ? all[i].vertex : all[i].compute) = texts[i][0].c_str();
      if (!texts[i][1].empty()) all[i].geometry = texts[i][1].c_str();
      if (!texts[i][2].empty()) all[i].fragment = texts[i][2].c_str();
    }
    return all;
  }();
  return sources[static_cast<size_t>(shader)];
}

}  // namespace furrow

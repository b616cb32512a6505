#include "furrow/frame_plan.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "plan_bindings.h"
#include "shaders/layout.h"

namespace furrow {
namespace {

static_assert(gpu::kLayerLimit == kMaxLayers);
static_assert(gpu::kMeasurePrincipal == static_cast<uint32_t>(Measure::kPrincipal) &&
              gpu::kCurveOat == static_cast<uint32_t>(Curve::kOat));
static_assert(sizeof(Affine) == gpu::kMatrixWords * sizeof(uint32_t) &&
              sizeof(JointMotion) == gpu::kMotionWords * sizeof(uint32_t));

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
constexpr std::array<Binding, 6> smoothBindings(Buffer to) {
  return {kFrameBinding,
          storage(0, Buffer::kRingOffsets, "ring_offsets"),
          storage(1, Buffer::kRingTriangles, "ring_triangles"),
          storage(2, Buffer::kRingWeights, "ring_weights"),
          storage(3, Buffer::kTriangleQ, "triangle_q"),
          storage(4, to, "point_q")};
}
constexpr std::array<Binding, 9> laplaceBindings(Buffer from, Buffer to) {
  return {kFrameBinding,
          storage(0, Buffer::kRingOffsets, "ring_offsets"),
          storage(1, Buffer::kRingTriangles, "ring_triangles"),
          storage(2, Buffer::kRingWeights, "ring_weights"),
          storage(3, Buffer::kTriangleQ, "triangle_q"),
          storage(4, Buffer::kSurfaceIndices, "surface_indices"),
          storage(5, Buffer::kVertexPoint, "vertex_point"),
          storage(6, from, "point_q"),
          storage(7, to, "smoothed_q")};
}
// What writes kPointQ, and what writes kOtherQ.
constexpr std::array kSmooth = {smoothBindings(Buffer::kPointQ), smoothBindings(Buffer::kOtherQ)};
constexpr std::array kLaplace = {laplaceBindings(Buffer::kOtherQ, Buffer::kPointQ),
                                 laplaceBindings(Buffer::kPointQ, Buffer::kOtherQ)};
constexpr Binding kRespondBindings[] = {kFrameBinding,
                                        storage(0, Buffer::kVertexPoint, "vertex_point"),
                                        storage(2, Buffer::kPointQ, "point_q"),
                                        storage(3, Buffer::kWeights, "weights"),
                                        storage(4, Buffer::kState, "state"),
                                        storage(6, Buffer::kBias, "bias")};

std::vector<uint32_t> restVertexWords(const AssetView& asset) {
  std::vector<uint32_t> words;
  words.reserve(size_t{asset.vertexCount()} * (3 + gpu::kRestFrameWords));
  for (const Float3& p : asset.positions)
    for (float value : {p.x, p.y, p.z}) words.push_back(wordOf(value));
  for (uint32_t v = 0; v < asset.vertexCount(); ++v) {
    const Float3 n = asset.normals[v];
    const Float4 t = asset.tangents[v];
    for (float value : {n.x, n.y, n.z, t.x, t.y, t.z, t.w}) words.push_back(wordOf(value));
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
    for (float value : layer.coefficients) words.push_back(wordOf(value));
  return words;
}

std::vector<uint32_t> ringWeightWords(const AssetView& asset) {
  std::vector<uint32_t> words((asset.ring_weights.size() + 1) / 2);
  std::ranges::copy(asset.ring_weights, reinterpret_cast<uint16_t*>(words.data()));
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

}  // namespace

// `bytes` of one instance, if it is of instances.
BufferDesc& FramePlan::add(Buffer id, const char* name, Lifetime lifetime, uint64_t bytes) {
  if (lifetime == Lifetime::kPerInstance) bytes *= options_.instances;
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
  if (options.form == Form::kClustered && (options.laplace_steps > 0 || !addClustered()))
    options_.form = Form::kStaged;
  if (options_.form != Form::kClustered) options_.instances = 1;
  addCommon();
  if (options_.form == Form::kStaged) addStaged();
  if (options_.form == Form::kRaster) addRaster();
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
  if (options_.ease)
    add(Buffer::kState, "furrow state", Lifetime::kPerInstance,
        vertices * asset.weightStride() * sizeof(float));
  if (options_.posed_by_host) return;
  fillWords(Buffer::kRestVertices, "furrow rest vertices", restVertexWords(asset));
  fillWords(Buffer::kInfluences, "furrow influences", influenceWords(asset));
  if (options_.form != Form::kClustered)
    fill(Buffer::kMorphEntries, "furrow morph entries", std::as_bytes(asset.morph_entries));
  add(Buffer::kPalette, "furrow palette", Lifetime::kPerInstance,
      asset.palette.size() * (options_.skinning == Skinning::kLinear ? sizeof(Affine) : sizeof(JointMotion)));
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
  if (options_.laplace_steps > 0)
    add(Buffer::kOtherQ, "furrow other point q", Lifetime::kPerInstance,
        asset.pointCount() * layers * sizeof(float));

  const auto dispatch = [&](const char* label, Shader shader, uint32_t count,
                            std::span<const Binding> bindings) {
    const uint32_t groups = (count + gpu::kGroupSize - 1) / gpu::kGroupSize;
    items_.push_back({.kind = ItemKind::kDispatch,
                      .label = label,
                      .shader = shader,
                      .groups = {std::min(groups, gpu::kGroupColumns),
                                 (groups + gpu::kGroupColumns - 1) / gpu::kGroupColumns},
                      .bindings = bindings});
    items_.push_back({.kind = ItemKind::kBarrier, .label = label});
  };
  if (!options_.posed_by_host)
    dispatch("furrow deform", Shader::kDeform, asset.vertexCount(), kDeformBindings);
  dispatch("furrow compress", Shader::kCompress, asset.triangleCount(), kCompressBindings);
  uint32_t steps = options_.laplace_steps;
  dispatch("furrow smooth", Shader::kSmooth, asset.pointCount(), kSmooth[steps % 2]);
  while (steps-- > 0) dispatch("furrow laplace", Shader::kLaplace, asset.pointCount(), kLaplace[steps % 2]);
  dispatch("furrow respond", Shader::kRespond, asset.vertexCount(), kRespondBindings);
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
  frame.fade = input.fade;
  frame.sums_height = sums_.height;
  frame.joints = static_cast<uint32_t>(asset.palette.size());
  frame.dual_quaternions = options_.skinning == Skinning::kDualQuaternion;
  frame.posed_by_host = options_.posed_by_host;
  frame.with_ease = options_.ease;
  frame.with_point_q = buffer(Buffer::kPointQ).bytes > 0;
  frame.active_layers = input.active_layers;
  frame.laplace_rate = input.laplace_rate;
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
    const Ease ease = input.reset || input.eases.empty() ? Ease() : input.eases[l];
    to.attack = easeStep(ease.attack, input.seconds);
    to.release = easeStep(ease.release, input.seconds);
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

}  // namespace furrow

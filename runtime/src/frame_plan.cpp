#include "furrow/frame_plan.h"

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

constexpr uint32_t kFrameSlot = 0;  // the uniform buffer; storage buffers count from 0 on their own

constexpr std::array<Binding, 9> kDeformBindings = {{{kFrameSlot, Buffer::kFrame},
                                                     {0, Buffer::kRestVertices},
                                                     {1, Buffer::kInfluences},
                                                     {2, Buffer::kMorphEntries},
                                                     {3, Buffer::kPalette},
                                                     {4, Buffer::kMorphWeights},
                                                     {5, Buffer::kPositions},
                                                     {6, Buffer::kNormals},
                                                     {7, Buffer::kTangents}}};
constexpr std::array<Binding, 5> kCompressBindings = {{{kFrameSlot, Buffer::kFrame},
                                                       {0, Buffer::kSurfaceIndices},
                                                       {1, Buffer::kCoefficients},
                                                       {2, Buffer::kPositions},
                                                       {3, Buffer::kTriangleQ}}};
constexpr std::array<Binding, 6> kSmoothBindings = {{{kFrameSlot, Buffer::kFrame},
                                                     {0, Buffer::kRingOffsets},
                                                     {1, Buffer::kRingTriangles},
                                                     {2, Buffer::kRingWeights},
                                                     {3, Buffer::kTriangleQ},
                                                     {4, Buffer::kPointQ}}};
constexpr std::array<Binding, 5> kRespondBindings = {{{kFrameSlot, Buffer::kFrame},
                                                      {0, Buffer::kVertexPoint},
                                                      {1, Buffer::kBias},
                                                      {2, Buffer::kPointQ},
                                                      {3, Buffer::kWeights}}};

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

}  // namespace

FramePlan::FramePlan(const AssetView& asset, const PlanOptions& options) {
  const uint64_t vertices = asset.vertexCount();
  const uint64_t triangles = asset.triangleCount();
  const uint64_t points = asset.pointCount();
  const uint64_t layers = asset.layerCount();

  words_.reserve(static_cast<size_t>(Buffer::kCount));
  const auto add = [&](Buffer id, const char* name, Lifetime lifetime, uint64_t bytes) -> BufferDesc& {
    return buffers_[static_cast<size_t>(id)] = {name, lifetime, bytes, {}};
  };
  const auto fill = [&](Buffer id, const char* name, std::span<const std::byte> initial) {
    add(id, name, Lifetime::kPerAsset, initial.size()).initial = initial;
  };
  const auto fillWords = [&](Buffer id, const char* name, std::vector<uint32_t> words) {
    words_.push_back(std::move(words));
    fill(id, name, std::as_bytes(std::span(words_.back())));
  };

  fill(Buffer::kSurfaceIndices, "furrow surface indices", std::as_bytes(asset.surface_indices));
  fillWords(Buffer::kCoefficients, "furrow coefficients", coefficientWords(asset));
  fill(Buffer::kRingOffsets, "furrow ring offsets", std::as_bytes(asset.ring_offsets));
  fill(Buffer::kRingTriangles, "furrow ring triangles", std::as_bytes(asset.ring_triangles));
  fillWords(Buffer::kRingWeights, "furrow ring weights", ringWeightWords(asset));
  fill(Buffer::kVertexPoint, "furrow vertex points", std::as_bytes(asset.vertex_point));
  if (hasBias(asset)) fillWords(Buffer::kBias, "furrow bias", biasWords(asset));
  add(Buffer::kFrame, "furrow frame", Lifetime::kPerInstance, sizeof(gpu::FrameConstants));
  add(Buffer::kPositions, "furrow posed positions", Lifetime::kPerInstance, vertices * sizeof(Float3));
  add(Buffer::kTriangleQ, "furrow triangle q", Lifetime::kPerInstance, triangles * layers * sizeof(float));
  add(Buffer::kPointQ, "furrow point q", Lifetime::kPerInstance, points * layers * sizeof(float));
  add(Buffer::kWeights, "furrow weights", Lifetime::kPerInstance,
      vertices * asset.weightStride() * sizeof(int16_t));
  if (!options.posed_by_host) {
    fillWords(Buffer::kRestVertices, "furrow rest vertices", restVertexWords(asset));
    fillWords(Buffer::kInfluences, "furrow influences", influenceWords(asset));
    fill(Buffer::kMorphEntries, "furrow morph entries", std::as_bytes(asset.morph_entries));
    add(Buffer::kPalette, "furrow palette", Lifetime::kPerInstance,
        asset.palette.size_bytes() / sizeof(PaletteEntry) * sizeof(Affine));
    add(Buffer::kMorphWeights, "furrow morph weights", Lifetime::kPerInstance,
        asset.morphs.size() * sizeof(Float2));
    if (options.normals) {
      add(Buffer::kNormals, "furrow posed normals", Lifetime::kPerInstance, vertices * sizeof(Float3));
      add(Buffer::kTangents, "furrow posed tangents", Lifetime::kPerInstance, vertices * sizeof(Float4));
    }
  }

  const auto dispatch = [&](const char* label, Shader shader, uint64_t items,
                            std::span<const Binding> bindings) {
    constexpr uint64_t kMaxGroups = 65535;  // in one dimension, as OpenGL and Vulkan guarantee
    const uint64_t groups = (items + gpu::kGroupSize - 1) / gpu::kGroupSize;
    const uint64_t rows = (groups + kMaxGroups - 1) / kMaxGroups;
    const uint64_t columns = rows ? (groups + rows - 1) / rows : 0;
    dispatches_.push_back(
        {label, shader, {static_cast<uint32_t>(columns), static_cast<uint32_t>(rows)}, bindings});
  };
  if (!options.posed_by_host) dispatch("furrow deform", Shader::kDeform, vertices, kDeformBindings);
  dispatch("furrow compress", Shader::kCompress, triangles, kCompressBindings);
  dispatch("furrow smooth", Shader::kSmooth, points, kSmoothBindings);
  dispatch("furrow respond", Shader::kRespond, vertices, kRespondBindings);
}

void writeFrameConstants(const AssetView& asset, const PlanOptions& options, const FrameInput& input,
                         std::span<std::byte> out) {
  gpu::FrameConstants frame = {};
  frame.vertices = asset.vertexCount();
  frame.triangles = asset.triangleCount();
  frame.points = asset.pointCount();
  frame.layers = asset.layerCount();
  frame.influences = asset.influences;
  frame.morphs = static_cast<uint32_t>(asset.morphs.size());
  frame.with_normals = options.normals;
  frame.with_bias = hasBias(asset);
  frame.inverse_scale2 = 1.0f / (input.scale * input.scale);
  uint32_t first = 0;
  for (uint32_t l = 0; l < frame.layers; ++l) {
    const Layer& layer = asset.layers[l];
    const Response& response = input.responses.empty() ? layer.response : input.responses[l];
    frame.layer[l] = {response.lambda,
                      response.beta,
                      response.stretch_lambda,
                      response.stretch_beta,
                      static_cast<uint32_t>(layer.measure),
                      static_cast<uint32_t>(response.curve),
                      first,
                      input.region_weights.empty() ? 0.0f : input.region_weights[l]};
    first += static_cast<uint32_t>(layer.coefficients.size());
  }
  if (out.size() >= sizeof frame) std::memcpy(out.data(), &frame, sizeof frame);
}

void writeMorphWeights(const AssetView& asset, const FrameInput& input, std::span<std::byte> out) {
  for (size_t m = 0; m < asset.morphs.size() && (m + 1) * sizeof(Float2) <= out.size(); ++m) {
    const Float2 steps = {input.morph_weights[m] * asset.morphs[m].position_step,
                          input.morph_weights[m] * asset.morphs[m].normal_step};
    std::memcpy(out.data() + m * sizeof steps, &steps, sizeof steps);
  }
}

const char* shaderSource(Shader shader) {
  using namespace shader_text;
  static const std::array<std::string, static_cast<size_t>(Shader::kCount)> sources = [] {
    const char* bodies[] = {kDeform, kCompress, kSmooth, kRespond};
    std::array<std::string, static_cast<size_t>(Shader::kCount)> texts;
    for (size_t i = 0; i < texts.size(); ++i)
      texts[i] = std::string("#version 430\n") + kLayout + kPrelude + bodies[i];
    return texts;
  }();
  return sources[static_cast<size_t>(shader)].c_str();
}

}  // namespace furrow

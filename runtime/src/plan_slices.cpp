// The raster form of a frame plan.

#include <algorithm>
#include <array>

#include "plan_bindings.h"
#include "shaders/layout.h"

namespace furrow {

namespace {

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
constexpr std::array<Binding, 5> laplaceBindings(Access from) {
  return {kFrameBinding,
          {0, Buffer::kCount, from, "sums"},
          words(1, Buffer::kVertexPoint, "vertex_point"),
          floats(2, Buffer::kMeasured, "measured"),
          {0, Buffer::kSurfaceIndices, Access::kIndices, nullptr}};
}
// What adds up to the first image, and what to the second.
constexpr std::array kLaplace = {laplaceBindings(Access::kOtherSums), laplaceBindings(Access::kSums)};
constexpr Binding kSums = {2, Buffer::kCount, Access::kSums, "sums"};
constexpr Binding kRasterEaseBindings[] = {kFrameBinding,
                                           words(0, Buffer::kVertexPoint, "vertex_point"),
                                           words(1, Buffer::kBias, "bias"),
                                           kSums,
                                           floats(3, Buffer::kState, "state"),
                                           capture(0, Buffer::kNextState)};
constexpr Binding kRasterRespondBindings[] = {
    kFrameBinding, words(0, Buffer::kVertexPoint, "vertex_point"), words(1, Buffer::kBias, "bias"),
    kSums,         floats(4, Buffer::kNextState, "next_state"),    capture(0, Buffer::kWeights)};
constexpr Binding kRasterKeepBindings[] = {kFrameBinding, floats(0, Buffer::kNextState, "next_state"),
                                           capture(0, Buffer::kState)};

constexpr const char* kPosedOutputs[] = {"posed_position", "posed_normal", "posed_tangent"};
constexpr const char* kPairOutputs[] = {"pair0", "pair1", "pair2", "pair3",
                                        "pair4", "pair5", "pair6", "pair7"};
constexpr const char* kStateOutputs[] = {"state0",  "state1",  "state2",  "state3", "state4",  "state5",
                                         "state6",  "state7",  "state8",  "state9", "state10", "state11",
                                         "state12", "state13", "state14", "state15"};
constexpr const char* kKeptOutputs[] = {"kept"};
static_assert(std::size(kPairOutputs) * 2 == kMaxLayers && std::size(kStateOutputs) == kMaxLayers);

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

void FramePlan::addRaster() {
  const AssetView& asset = *asset_;
  // Captures what `shader` gives for `count` points.
  const auto capturing = [&](const char* label, Shader shader, uint32_t count,
                             std::span<const Binding> bindings, std::span<const char* const> outputs) {
    items_.push_back({.kind = ItemKind::kDraw,
                      .label = label,
                      .shader = shader,
                      .count = count,
                      .bindings = bindings,
                      .captured = outputs});
    items_.push_back({.kind = ItemKind::kBarrier, .label = label});
  };
  const uint32_t vertices = asset.vertexCount(), stride = asset.weightStride();
  if (!options_.posed_by_host) {
    const std::span bindings(kRasterDeformBindings);
    const size_t outputs = options_.normals ? 3 : 1;
    capturing("furrow deform", Shader::kRasterDeform, vertices, bindings.first(bindings.size() - 3 + outputs),
              std::span(kPosedOutputs).first(outputs));
  }
  addSlices();
  const auto adding = [&](const char* label, Shader shader, uint32_t image,
                          std::span<const Binding> bindings) {
    for (uint32_t s = 0; s < slices_.size(); ++s) {
      items_.push_back({.kind = ItemKind::kClear, .label = "furrow clear sums", .slice = s, .image = image});
      items_.push_back({.kind = ItemKind::kDraw,
                        .label = label,
                        .shader = shader,
                        .first = slices_[s].first,
                        .count = slices_[s].count,
                        .slice = s,
                        .image = image,
                        .bindings = bindings});
    }
    items_.push_back({.kind = ItemKind::kBarrier, .label = label});
  };
  uint32_t steps = options_.laplace_steps;
  adding("furrow measure", Shader::kRasterMeasure, steps % 2, kRasterMeasureBindings);
  while (steps-- > 0) adding("furrow laplace", Shader::kRasterLaplace, steps % 2, kLaplace[steps % 2]);
  if (options_.ease) {
    add(Buffer::kNextState, "furrow next state", Lifetime::kPerInstance,
        uint64_t{vertices} * stride * sizeof(float));
    capturing("furrow ease", Shader::kRasterEase, vertices, kRasterEaseBindings,
              std::span(kStateOutputs).first(stride));
    capturing("furrow keep", Shader::kRasterKeep, vertices * stride, kRasterKeepBindings, kKeptOutputs);
  }
  capturing("furrow respond", Shader::kRasterRespond, vertices, kRasterRespondBindings,
            std::span(kPairOutputs).first(stride / 2));
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
    Slice slice = {{kAbsent, kAbsent, kAbsent},
                   static_cast<uint32_t>(measured.size()),
                   3,
                   static_cast<uint32_t>(indices.size()),
                   static_cast<uint32_t>(3 * triangles.size())};
    uint32_t count = 0;
    for (uint32_t other = l; other < asset.layerCount() && count < gpu::kLayersASlice; ++other) {
      const bool same = std::all_of(measuring.begin(), measuring.end(),
                                    [&](uint32_t bits) { return (bits >> l & 1u) == (bits >> other & 1u); });
      if (done >> other & 1u || !same) continue;
      done |= 1u << other;
      slice.layers[count++] = other;
      slice.record_words += coefficientCount(asset.layers[other].measure);
    }
    for (uint32_t t : triangles) {
      for (size_t c = 0; c < 3; ++c) {
        indices.push_back(asset.surface_indices[3 * size_t{t} + c]);
        measured.push_back(wordOf(static_cast<float>(angles[3 * size_t{t} + c])));
      }
      for (uint32_t c = 0; c < count; ++c) {
        const Layer& layer = asset.layers[slice.layers[c]];
        const uint32_t each = coefficientCount(layer.measure);
        for (float value : layer.coefficients.subspan(size_t{t} * each, each))
          measured.push_back(wordOf(value));
      }
    }
    slices_.push_back(slice);
  }
  fillWords(Buffer::kSurfaceIndices, "furrow measured corners", std::move(indices));
  fillWords(Buffer::kMeasured, "furrow measured triangles", std::move(measured));
  sums_ = {gpu::kSumsWidth, (asset.pointCount() + gpu::kSumsWidth - 1) / gpu::kSumsWidth,
           static_cast<uint32_t>(slices_.size()), options_.laplace_steps > 0 ? 2u : 1u};
}

}  // namespace furrow

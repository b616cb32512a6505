#pragma once

// The cpu tier: the frame as jobs over ranges.
//
// A job is a struct of spans that owns nothing. validate() checks the sizes once; run(begin, end) does a part
// of the work and may be called from any number of threads on disjoint ranges. No job allocates, locks or
// throws. The results do not depend on how the range is split. Within a frame the order is Deform, Compress,
// Smooth, Respond; each needs the whole result of the one before.

#include <span>

#include "furrow/asset.h"

namespace furrow {

// Posed vertices from a palette and morph weights: linear blend skinning of the morphed rest vertices.
// Items: vertices. Sources: glTF 2.0, 3.7.2.2 (morph targets) and 3.7.3 (skins).
struct DeformJob {
  const AssetView* asset = nullptr;
  std::span<const Affine> palette;  // asset->palette.size(), translations relative to the instance's origin
  std::span<const float> morph_weights;  // asset->morphs.size()
  std::span<Float3> positions;           // out, a vertex
  std::span<Float3> normals;             // out, a vertex, unit; or empty
  std::span<Float4> tangents;            // out, a vertex, unit xyz; or empty (needs normals)

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// q of each triangle for one layer: 1 at rest, clamped to [0, 4]; -1 for a triangle that is in no ring; 1
// where the input is not finite. Items: triangles.
struct CompressJob {
  const AssetView* asset = nullptr;
  uint32_t layer = 0;
  std::span<const Float3> positions;  // posed, a vertex
  float scale = 1.0f;                 // uniform scale of the instance that `positions` contain, > 0
  std::span<float> q;                 // out, a triangle

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// q of each point: the mean over its ring, weighted by rest angle; 1 where the ring is empty.
// Items: points.
struct SmoothJob {
  const AssetView* asset = nullptr;
  std::span<const float> triangle_q;  // a triangle
  std::span<float> q;                 // out, a point

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// The weight of each vertex for one layer: w = clamp(I(1/q) - I_s(q) + bias + region, -1, 1), as snorm16 (w *
// 32767, rounded). Items: vertices.
struct RespondJob {
  const AssetView* asset = nullptr;
  uint32_t layer = 0;
  Response response;           // usually asset->layers[layer].response
  float region = 0.0f;         // region weight, [-1, 1]
  std::span<const float> q;    // a point
  std::span<int16_t> weights;  // out, asset->weightStride() a vertex; only this layer's entry is written

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// alpha = 1 / max(q, 1/64).
inline constexpr float kMinQ = 1.0f / 64.0f;
inline constexpr float kMaxQ = 4.0f;

// One weight by the arithmetic of RespondJob, in [-1, 1]; for plots and tools.
float respond(const Response& response, float q, float bias, float region);

}  // namespace furrow

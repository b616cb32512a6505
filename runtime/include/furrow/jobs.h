#pragma once

// The cpu tier: the frame as jobs over ranges.
//
// A job is a struct of spans that owns nothing. validate() checks the sizes once; run(begin, end) does a part
// of the work and may be called from any number of threads on disjoint ranges. No job allocates, locks or
// throws. The results do not depend on how the range is split. Within a frame the order is Deform, Compress,
// Smooth, (Laplace,) Respond, (Ease); each needs the whole result of the one before.

#include <span>

#include "furrow/asset.h"
#include "furrow/simd.h"
#include "furrow/skinning.h"

namespace furrow {

// Posed vertices from a palette and morph weights: the rest vertices are morphed, then skinned. Targets of
// weight 0 cost nothing. Normals and tangents come out unit and orthogonal. Items: vertices.
// Sources: glTF 2.0, 3.7.2.2 (morph targets) and 3.7.3 (skins); skinning.h.
struct DeformJob {
  const AssetView* asset = nullptr;
  // asset->palette.size(), translations relative to the instance's origin. A matrix that is not finite spoils
  // all vertices that name its joint, with weight 0 too.
  std::span<const Affine> palette;
  std::span<const float> morph_weights;  // asset->morphs.size()
  std::span<Float3> positions;           // out, a vertex
  std::span<Float3> normals;             // out, a vertex, unit; or empty
  std::span<Float4> tangents;            // out, a vertex, unit xyz; or empty (needs normals)
  Skinning skinning = Skinning::kLinear;
  std::span<const JointMotion> motions = {};  // of the palette, by splitPalette(); for kDualQuaternion alone
  Simd simd = bestSimd();                     // the same bits from all

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

// More smoothing, between Smooth and Respond: one Laplacian step over the points of one layer,
//
//   out = mean of q + rate * (m - q)
//
// over the triangles of the point's ring that are in the layer, weighted by rest angle; m is the mean of q at
// a triangle's other two corners. Every step widens what a crease reacts to by about one edge. Constant q
// stays as it is. Steps are made by swapping q and out. Items: points.
struct LaplaceJob {
  const AssetView* asset = nullptr;
  std::span<const float> triangle_q;  // a triangle, of CompressJob: below 0 the triangle is not in the layer
  std::span<const float> q;           // a point
  float rate = 0.5f;                  // [0, 1]
  std::span<float> out;               // a point; not q

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

// How fast the weight of a layer follows, in 1/s: after 1 / rate seconds 63 % of the way is done. Not above
// 0, or infinite: at once.
struct Ease {
  float attack = 0.0f;   // where the weight grows away from 0
  float release = 0.0f;  // where it falls back, or changes its sign
};

// The share of the way to its target that a weight goes in a step: 1 - exp(-rate seconds), 1 for at once.
float easeStep(float rate, float seconds);

// After Respond or the clustered frame: weights follow their targets in time, and fade out. With t the weight
// that the frame computed and s the state,
//
//   w = s + (t - s) * easeStep(|t| > |s| ? attack : release, seconds),   s = w
//   weight = w * fade
//
// Two half steps are one whole step, so nothing depends on the frame rate; only a step in which a weight
// changes its sign keeps the rate it began with. Items: vertices.
struct EaseJob {
  const AssetView* asset = nullptr;
  std::span<const Ease> eases;  // a layer; or empty: every layer at once, and no state is needed
  float seconds = 0.0f;         // since the last step, >= 0
  bool reset = false;           // s = t: for the first frame, cuts and teleports
  float fade = 1.0f;            // [0, 1], with distance; not part of s
  std::span<float> state;       // weightStride() a vertex; of the instance, kept from frame to frame
  std::span<int16_t> weights;   // in: t, out: the weight; weightStride() a vertex

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// alpha = 1 / max(q, 1/64).
inline constexpr float kMinQ = 1.0f / 64.0f;
inline constexpr float kMaxQ = 4.0f;

// One weight by the arithmetic of RespondJob, in [-1, 1]; for plots and tools.
float respond(const Response& response, float q, float bias, float region);

}  // namespace furrow

#pragma once

// Poses that a host brings: its own vertex buffers, and key frames of them, as the floats the frame reads.
// Jobs as in jobs.h: they own nothing, and run() may be called on disjoint ranges from any threads.

#include <cstddef>
#include <span>

#include "furrow/asset.h"

namespace furrow {

enum class VertexFormat : uint8_t {
  kFloat3 = 0,
  kHalf3,  // IEEE 754 binary16. Its step is 1/2048 of the coordinate: at coordinates of 1 and edges of 0.01,
           // alpha is off by up to 10 %. Give positions relative to the character, or floats
};

// Element i: three numbers at bytes[offset + i * stride], of any alignment.
struct VertexStream {
  std::span<const std::byte> bytes;
  size_t offset = 0;
  size_t stride = sizeof(Float3);
  VertexFormat format = VertexFormat::kFloat3;

  uint64_t count() const;  // whole elements within `bytes`
};

enum class KeyCurve : uint8_t {
  kLinear = 0,  // (1 - t) a + t b
  kQuadratic,   // (1 - t^2) a + t^2 b: leaves the first key slowly  [The Cg Tutorial, 6.4]
};

// Vertices from one stream, or from a pair of key frames. Items: elements of `out`.
struct PoseJob {
  VertexStream from;
  VertexStream to;    // the second key frame; empty: `from` alone
  float time = 0.0f;  // [0, 1] between the key frames; beyond it extrapolates
  KeyCurve curve = KeyCurve::kLinear;
  // Which element of the streams each element of `out` is, so that a host may keep its own vertex order;
  // empty: the same one. kAbsent: none, which becomes NaN, and the frame takes q = 1 for its triangles.
  std::span<const uint32_t> element;
  bool patch = false;  // leave what is kAbsent as it is: a pose made of several meshes
  bool unit = false;   // normals: make the result unit length; +Y where it has no direction
  std::span<Float3> out;

  Status validate() const;  // reads every `element` once
  void run(uint32_t begin, uint32_t end) const;
};

// Occlusion of each vertex carried along with the morph targets [GPU Gems, ch. 4, "Dawn"]: how open a vertex
// is was baked at rest and once a target, and
//
//   out = clamp(rest + sum over the targets of weight * delta, 0, 1)
//
// costs only where active targets move something. No asset holds occlusion: the host bakes it, by
// AssetView::source_vertex, with delta = (baked with the target at 1) - rest. Items: vertices.
struct OcclusionJob {
  const AssetView* asset = nullptr;
  std::span<const float> morph_weights;            // asset->morphs.size()
  std::span<const float> rest;                     // a vertex
  std::span<const std::span<const float>> deltas;  // a target: empty, or beside Morph::vertices
  std::span<float> out;                            // a vertex

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

}  // namespace furrow

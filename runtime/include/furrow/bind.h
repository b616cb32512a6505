#pragma once

// Binding: from the vertices of an engine's own buffers, which its importer reordered, split or merged, to
// the points of an asset. A vertex of point p has the weights of asset vertex point_vertex[p].

#include <span>

#include "furrow/asset.h"

namespace furrow {

inline constexpr uint32_t kUnmatched = 0xffffffffu;  // no vertex of the source lies there
inline constexpr uint32_t kAmbiguous = 0xfffffffeu;  // several points lie there, and nothing tells them apart

struct BindCounts {
  uint32_t matched = 0, ambiguous = 0, unmatched = 0;
};

// One mesh: a vertex goes through the place hash to its place, in O(1). Where a place holds several points
// (lips that touch, a sleeve on an arm), they are told apart by where the other corners of the vertex's
// triangles lie. Owns nothing and allocates nothing.
//
// A vertex that is not of the source's mesh is unmatched: its position has to give the place's 16-bit check
// value and to lie within AssetView::place_error of the place, which is about half a step of the quantised
// positions. Of vertices elsewhere none gets through; of those that lie that near a place without being
// there, one in 2^16 times the number of places.
//
// Exact positions need no tolerance if they are those of the source's file and `to_root` is Part::rest of
// their part: the cook brings them to root space by the same arithmetic. With a tolerance, a vertex that the
// hash does not know takes the nearest point within it. Points are then where the asset's own geometry is,
// which is off the source by up to AssetView::position_error: that is added to the tolerance, and a vertex to
// which two places are equally near within that error is ambiguous.
struct BindJob {
  const AssetView* asset = nullptr;
  std::span<const Float3> positions;  // a vertex, in the bind pose
  std::span<const uint32_t> indices;  // 3 a triangle; may be empty, then every place with several points is
                                      // ambiguous
  Affine to_root;                     // a similarity: from `positions` to the asset's root space
  float tolerance = 0.0f;             // root-space units; well below the edges' lengths
  std::span<uint32_t> scratch;        // scratchSize() numbers
  std::span<uint32_t> points;         // out, a vertex: its point, kUnmatched or kAmbiguous

  size_t scratchSize() const;

  Status validate() const;  // of every size, number and index
  BindCounts run() const;   // only after validate()
};

}  // namespace furrow

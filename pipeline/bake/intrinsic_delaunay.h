#pragma once

// The intrinsic Delaunay triangulation of a surface: the same points on the same surface, with edges flipped
// within it (a new one bends where the old one was) until no two angles that face an edge add up to more than
// 180 degrees. Its cotangent Laplacian has no negative weights and does not depend on who triangulated the
// surface [Bobenko and Springborn 2007; Fisher et al. 2007].

#include <array>
#include <cstdint>
#include <vector>

namespace furrow::pipeline {

struct IntrinsicTriangle {
  std::array<uint32_t, 3> corners;  // points
  std::array<double, 3> lengths;    // > 0, of the side that faces each corner

  double cotangent(int corner) const;  // of the angle there
};

constexpr uint32_t kNoSide = ~0u;

// The triangles have an area. Sides of one triangle, of more than two, and of two that are turned against
// each other stay as they are. Two points may come to share several sides, and one point to be two corners
// of a triangle. Returns the twin of every side, 3 * triangle + the corner that it faces: the same side in
// the other triangle; kNoSide where it has none.
std::vector<uint32_t> makeDelaunay(std::vector<IntrinsicTriangle>& triangles);

}  // namespace furrow::pipeline

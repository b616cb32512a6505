#pragma once

// How the animation squeezes the surface: the compressive part of each triangle's strain over the poses of
// bake/poses.h.

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "pipeline/bake/surface.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Squeeze {
  // Per triangle, the sum over poses of s^2 v v^T, with s = 1 - (smallest stretch) > 0 and v its direction at
  // rest, as a symmetric tensor xx xy yy in the triangle's frame (x along its first edge).
  std::vector<glm::vec3> tensor;
  std::vector<float> peak;        // per triangle, largest s, [0, 1]
  std::vector<uint8_t> by_morph;  // per triangle, whether a morph target squeezes it: a face, not clothing
  bool any = false;               // whether anything is squeezed
};

// `scene` holds the positions that `surface` was made from; `source_vertex` maps surface vertices to source
// order.
Squeeze measureSqueeze(const SourceScene& scene, const Surface& surface,
                       const std::vector<uint32_t>& source_vertex, uint32_t threads);

// Frame of a triangle: origin-free edges e1, e2 in 2D, x along e1.
struct TriangleFrame {
  glm::dvec3 x, y;
  double e1x, e2x, e2y;
};
TriangleFrame triangleFrame(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c);

}  // namespace furrow::pipeline

#pragma once

// Nearest places of a surface.

#include <array>
#include <memory>
#include <vector>

#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// Barycentric coordinates of the triangle's place nearest to p [Ericson, Real-Time Collision
// Detection, 5.1.5]; any of its places if it has no area.
glm::dvec3 nearestPlace(const std::array<glm::dvec3, 3>& triangle, glm::dvec3 p);

// Over the covered triangles that are not degenerate, of which there must be one.
class NearestTriangle {
 public:
  struct Found {
    size_t triangle = 0;
    glm::dvec3 barycentric{1.0, 0.0, 0.0};
    double distance = 0.0;
  };

  // `surface` outlives it.
  NearestTriangle(const Surface& surface, const std::vector<bool>& covered);
  ~NearestTriangle();

  Found find(glm::dvec3 p) const;  // of several that are equally near, any, but always the same
  double meanEdge() const { return mean_edge_; }

 private:
  class Tree;
  std::unique_ptr<Tree> tree_;
  double mean_edge_ = 0.0;
};

}  // namespace furrow::pipeline

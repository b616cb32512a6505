#pragma once

// What is unusual about a surface. All of it cooks; the report tells.

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace furrow::pipeline {

struct Topology {
  uint32_t degenerate_triangles = 0;  // needles, or two corners in one point: in no ring
  uint32_t duplicate_triangles = 0;   // the corners of one before, facing the same way or not
  uint32_t non_manifold_edges = 0;    // between two points, with more than two triangles
  uint32_t border_edges = 0;          // with one
  uint32_t isolated_vertices = 0;     // in no triangle: their layers' weights are those of no squeeze
};

// `triangles` by vertex. Degenerate and duplicate triangles are not counted at the edges.
Topology inspect(std::span<const glm::vec3> positions, std::span<const uint32_t> vertex_point,
                 std::span<const glm::uvec3> triangles);

}  // namespace furrow::pipeline

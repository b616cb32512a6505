#pragma once

// From positions to places: which vertices lie at one place, exactly or within a tolerance.

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace furrow::pipeline {

// Positions and places are numbered in the order in which the vertices first meet them.
struct Places {
  std::vector<uint32_t> vertex_position;  // a vertex: index into positions
  std::vector<glm::vec3> positions;       // pairwise different (-0 equals 0)
  std::vector<uint32_t> position_place;   // a position: its place, < count
  uint32_t count = 0;
};

// `positions`: finite, at most 2^30, one a vertex. With tolerance 0 a place is one position. Else two
// vertices are at one place if a chain of vertices leads from one to the other with steps of at most
// `tolerance`, measured in double: no pair within it is missed, wherever it lies.
//
// Expected time is linear. Nothing is returned if the tolerance is so coarse that it would not be: more than
// about a thousand vertices lie within a few tolerances of one another.
std::optional<Places> findPlaces(std::span<const glm::vec3> positions, float tolerance);

// The tolerance that makes one place of positions which differ by rounding alone: 8 * 2^-23 of the largest
// coordinate, and at most 1/16 of `short_edge`, so that no edge is closed.
float roundingTolerance(std::span<const glm::vec3> positions, double short_edge);

}  // namespace furrow::pipeline

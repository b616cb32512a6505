#pragma once

// A signed distance as a surface, by surface nets [Gibson 1998]; where several sheets of the surface pass
// through a cell, each has a point of its own there [Nielson 2004, Dual Marching Cubes].

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace furrow::content {

struct SurfaceNet {
  std::vector<glm::dvec3> points;
  std::vector<std::array<uint32_t, 4>> quads;  // counter-clockwise from outside
};

// Where `distance` is 0 within the box, one point a cell of side `step` and sheet, drawn onto the surface. A
// box that is symmetric about a plane gives a symmetric net if the distance is.
SurfaceNet surfaceNet(const std::function<double(glm::dvec3)>& distance, glm::dvec3 low, glm::dvec3 high,
                      double step);

// By central differences; not normalised.
glm::dvec3 slopeOf(const std::function<double(glm::dvec3)>& distance, glm::dvec3 p);

}  // namespace furrow::content

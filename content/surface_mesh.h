#pragma once

// A polygon surface while it is being modelled: points that are shared over UV seams, and charts that are
// not.

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "content/scene.h"

namespace furrow::content {

struct SurfaceMesh {
  struct Triangle {
    std::array<uint32_t, 3> points;
    std::array<uint32_t, 3> vertices;
  };
  struct Vertex {
    uint32_t point;
    glm::dvec2 uv;
  };
  std::vector<glm::dvec3> points;
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;

  uint32_t addVertex(uint32_t point, glm::dvec2 uv);
  void addTriangle(uint32_t a, uint32_t b, uint32_t c);          // vertices
  void addQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d);  // cut along its shorter diagonal
};

// Unit normals of the points when they stand at `positions`, weighted by corner angle; one a point.
std::vector<glm::dvec3> pointNormals(const SurfaceMesh& mesh, std::span<const glm::dvec3> positions);

// 0 below `a`, 1 above `b`, smooth between; a > b falls instead.
double smoothRamp(double a, double b, double x);
// 1 at 0, 0 at and beyond +-1, smooth.
double bump(double x);

}  // namespace furrow::content

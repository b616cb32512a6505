#include "content/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace furrow::content {

uint32_t SurfaceMesh::addVertex(uint32_t point, glm::dvec2 uv) {
  vertices.push_back({point, uv});
  return static_cast<uint32_t>(vertices.size() - 1);
}

void SurfaceMesh::addTriangle(uint32_t a, uint32_t b, uint32_t c) {
  triangles.push_back({{vertices[a].point, vertices[b].point, vertices[c].point}, {a, b, c}});
}

void SurfaceMesh::addQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  const auto at = [&](uint32_t v) { return points[vertices[v].point]; };
  if (glm::distance(at(a), at(c)) <= glm::distance(at(b), at(d))) {
    addTriangle(a, b, c);
    addTriangle(a, c, d);
  } else {
    addTriangle(a, b, d);
    addTriangle(b, c, d);
  }
}

std::vector<glm::dvec3> pointNormals(const SurfaceMesh& mesh, std::span<const glm::dvec3> positions) {
  std::vector<glm::dvec3> normals(mesh.points.size(), glm::dvec3(0));
  for (const SurfaceMesh::Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle.points;
    const glm::dvec3 cross = glm::cross(positions[b] - positions[a], positions[c] - positions[a]);
    const double length = glm::length(cross);
    if (length < 1e-14) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 p = positions[triangle.points[corner]];
      const glm::dvec3 e = positions[triangle.points[(corner + 1) % 3]] - p;
      const glm::dvec3 f = positions[triangle.points[(corner + 2) % 3]] - p;
      normals[triangle.points[corner]] += cross / length * std::atan2(length, glm::dot(e, f));
    }
  }
  for (glm::dvec3& n : normals) n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::dvec3(0, 0, 1);
  return normals;
}

double smoothRamp(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double bump(double x) {
  const double t = std::max(0.0, 1 - x * x);
  return t * t;
}

}  // namespace furrow::content

#pragma once

// Surfaces by formula, for tests and benchmarks of the maps.

#include <functional>
#include <glm/geometric.hpp>

#include "pipeline/bake/tangents.h"
#include "pipeline/maps/synthesis.h"

namespace furrow::tests {

using pipeline::LayerField;
using pipeline::Surface;
using pipeline::SurfacePart;
using Map = std::function<glm::vec3(double u, double v)>;

// A grid over [0, 1]^2 of UV; `wraps`: its last column has the points of its first. `shift` moves the UVs'
// origin along u by as many columns.
inline Surface grid(uint32_t columns, uint32_t rows, const Map& position, const Map& normal,
                    bool wraps = false, uint32_t shift = 0) {
  Surface surface;
  const uint32_t point_columns = wraps ? columns : columns + 1;
  for (uint32_t row = 0; row <= rows; ++row) {
    for (uint32_t column = 0; column < point_columns; ++column) {
      const double u = column / static_cast<double>(columns), v = row / static_cast<double>(rows);
      surface.point_positions.push_back(position(u, v));
      surface.point_normals.push_back(glm::normalize(normal(u, v)));
    }
  }
  for (uint32_t row = 0; row <= rows; ++row) {
    for (uint32_t column = 0; column <= columns; ++column) {
      const uint32_t point = row * point_columns + (column + shift) % point_columns;
      surface.vertex_point.push_back(point);
      surface.positions.push_back(surface.point_positions[point]);
      surface.normals.push_back(surface.point_normals[point]);
      surface.uvs.emplace_back(column / static_cast<double>(columns), row / static_cast<double>(rows));
    }
  }
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t a = row * (columns + 1) + column, b = a + 1, c = a + columns + 1, d = c + 1;
      surface.triangles.emplace_back(a, c, b);
      surface.triangles.emplace_back(b, c, d);
    }
  }
  surface.tangents = pipeline::tangents(surface.positions, surface.normals, surface.uvs, surface.triangles);
  SurfacePart part;
  part.vertex_end = static_cast<uint32_t>(surface.positions.size());
  part.triangle_end = static_cast<uint32_t>(surface.triangles.size());
  part.has_uvs = true;
  surface.parts = {part};
  return surface;
}

// All of it, and the direction is everywhere nearest to `axis`.
inline LayerField along(const Surface& surface, const glm::vec3& axis) {
  LayerField field;
  for (const glm::vec3& normal : surface.point_normals) {
    field.direction.push_back(glm::normalize(axis - normal * glm::dot(axis, normal)));
  }
  field.confidence.assign(surface.point_positions.size(), 1.0f);
  field.strength.assign(surface.point_positions.size(), 1.0f);
  return field;
}

}  // namespace furrow::tests

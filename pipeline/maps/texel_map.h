#pragma once

// From texels to the surface.

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// Texels over a window of UV space. UVs repeat: the window may reach over the border of the unit square.
struct TexelGrid {
  uint32_t width = 0, height = 0;
  glm::dvec2 low{0.0}, extent{1.0};  // of the window; extents in (0, 1]
};

// Where each texel lies on the surface: triangle (global index, or kNoIndex outside every chart) and
// barycentric coordinates of its centre. A texel whose centre is outside, but no further from a chart than
// `margin` texels (at least half a texel's diagonal, so that every texel a chart touches is covered), is
// given the nearest point of the chart's border.
struct TexelMap {
  TexelGrid grid;
  std::vector<uint32_t> triangle;
  std::vector<glm::vec2> barycentric;  // of corners 1 and 2
};

// The charts of some parts: their triangles, and the edges where they end.
struct Charts {
  struct Edge {  // from a corner of a triangle to the next one
    uint32_t triangle = 0, corner = 0;
  };
  struct OfPart {
    uint32_t triangle_begin = 0, triangle_end = 0;
    std::vector<Edge> borders;
  };
  std::vector<OfPart> parts;  // in the order of their triangles
};
Charts chartsOf(const Surface& surface, std::span<const uint32_t> parts);

// Of a triangle larger than the unit square, one period is mapped. Where charts overlap, the triangle of the
// lowest index has the texel. Triangles whose UVs are not finite are left out.
TexelMap mapTexels(const Surface& surface, const Charts& charts, const TexelGrid& grid, uint32_t margin,
                   uint32_t threads = 1);

// The vertices' tangent frame at a place of the surface; none where opposite tangents meet.
struct TangentFrame {
  glm::vec3 tangent, bitangent, normal;  // unit, tangent and bitangent orthogonal to the normal
};
std::optional<TangentFrame> frameAt(const Surface& surface, uint32_t triangle, glm::vec2 barycentric);

}  // namespace furrow::pipeline

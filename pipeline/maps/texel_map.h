#pragma once

// From texels to the surface.

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// Where each texel of a size x size texture lies on the surface: triangle (global index, or kNoIndex outside
// every chart) and barycentric coordinates of its centre. A texel whose centre is outside, but no further
// from a chart than `margin` texels (at least half a texel's diagonal, so that every texel a chart touches is
// covered), is given the nearest point of the chart's border.
struct TexelMap {
  uint32_t size = 0;
  std::vector<uint32_t> triangle;
  std::vector<glm::vec2> barycentric;  // of corners 1 and 2
};

// UVs repeat outside [0, 1]; of a triangle larger than the texture, one period is mapped. Where charts
// overlap, the triangle of the lowest index has the texel. Triangles whose UVs are not finite are left out.
TexelMap mapTexels(const Surface& surface, std::span<const uint32_t> parts, uint32_t size, uint32_t margin);

}  // namespace furrow::pipeline

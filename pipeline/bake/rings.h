#pragma once

// One-rings of the points, weighted by rest angle.

#include <cstdint>
#include <vector>

#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// Point p's triangles are triangles[offsets[p]] to triangles[offsets[p + 1]], ascending, with weights that
// sum to exactly 65535. Degenerate triangles (no area, or two corners in one point) are in no ring.
struct Rings {
  std::vector<uint32_t> offsets;
  std::vector<uint32_t> triangles;
  std::vector<uint16_t> weights;
};

Rings makeRings(const Surface& surface);

// Whether a triangle is no measure of anything: two corners are one point, or it is a needle more than 2000
// times as long as high, whose height is the rounding of its corners.
bool isDegenerate(const Surface& surface, size_t triangle);

}  // namespace furrow::pipeline

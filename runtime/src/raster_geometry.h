#pragma once

// From posed triangles to snapped polygons on the screen.

#include "furrow/raster.h"

namespace furrow {

inline constexpr int32_t kSubpixels = 256;
// Pixels beyond the picture that triangles may reach before they are clipped: an edge within it, over a
// block's samples, fits 32 bits.
inline constexpr uint32_t kGuardBand = 1024;

// Values of RasterVertex::x that are marks.
inline constexpr int32_t kClippedVertex = INT32_MIN, kInvalidVertex = INT32_MIN + 1;

struct ClipPoint {
  double x, y, z, w;
};
ClipPoint clipPoint(const RasterJob& job, Float3 p);
RasterVertex screenVertex(const RasterJob& job, const ClipPoint& p);

// A triangle, or what clipping leaves of it: convex, wound as the triangle is. Nothing: count 0.
struct ScreenPolygon {
  uint32_t count = 0;
  RasterVertex points[8];
};
ScreenPolygon screenPolygon(const RasterJob& job, uint32_t triangle);

}  // namespace furrow

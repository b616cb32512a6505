#include "src/raster_geometry.h"

#include <algorithm>
#include <cmath>

namespace furrow {
namespace {

constexpr uint32_t kPlanes = 5;

// Not negative: inside. The near plane comes first, so that w is positive for the others.
double distance(const RasterJob& job, const ClipPoint& p, uint32_t plane) {
  const double reach_x = 1.0 + 2.0 * kGuardBand / job.width, reach_y = 1.0 + 2.0 * kGuardBand / job.height;
  switch (plane) {
    case 0:
      return p.z + p.w;
    case 1:
      return reach_x * p.w + p.x;
    case 2:
      return reach_x * p.w - p.x;
    case 3:
      return reach_y * p.w + p.y;
    default:
      return reach_y * p.w - p.y;
  }
}

// Always from the inner end: the two triangles of an edge get the same point.
ClipPoint crossing(const ClipPoint& in, const ClipPoint& out, double d_in, double d_out) {
  const double t = d_in / (d_in - d_out);
  return {in.x + (out.x - in.x) * t, in.y + (out.y - in.y) * t, in.z + (out.z - in.z) * t,
          in.w + (out.w - in.w) * t};
}

int32_t snapped(double pixels) {
  return static_cast<int32_t>(std::floor(pixels * kSubpixels + 0.5));
}

RasterVertex onScreen(const RasterJob& job, const ClipPoint& p) {
  return {snapped((0.5 + 0.5 * p.x / p.w) * job.width), snapped((0.5 - 0.5 * p.y / p.w) * job.height),
          static_cast<float>(p.z / p.w), static_cast<float>(p.w)};
}

}  // namespace

ClipPoint clipPoint(const RasterJob& job, Float3 p) {
  const auto row = [&](int r) {
    const float* m = job.view_projection + 4 * r;
    return ((double{m[0]} * p.x + double{m[1]} * p.y) + double{m[2]} * p.z) + m[3];
  };
  return {row(0), row(1), row(2), row(3)};
}

RasterVertex screenVertex(const RasterJob& job, const ClipPoint& p) {
  if (!std::isfinite(p.x + p.y + p.z + p.w)) return {kInvalidVertex, 0, 0.0f, 0.0f};
  for (uint32_t plane = 0; plane < kPlanes; ++plane)
    if (distance(job, p, plane) < 0.0) return {kClippedVertex, 0, 0.0f, 0.0f};
  if (!(p.w > 0.0)) return {kClippedVertex, 0, 0.0f, 0.0f};
  return onScreen(job, p);
}

ScreenPolygon screenPolygon(const RasterJob& job, uint32_t triangle) {
  const uint32_t* corner = &job.asset->indices[size_t{3} * triangle];
  ScreenPolygon polygon;
  bool whole = true;
  for (int i = 0; i < 3; ++i) {
    polygon.points[i] = job.vertices[corner[i]];
    if (polygon.points[i].x == kInvalidVertex) return {};
    whole = whole && polygon.points[i].x != kClippedVertex;
  }
  polygon.count = 3;
  if (whole) return polygon;

  ClipPoint points[8], kept[8];
  uint32_t count = 3;
  for (int i = 0; i < 3; ++i) points[i] = clipPoint(job, job.positions[corner[i]]);
  for (uint32_t plane = 0; plane < kPlanes && count > 0; ++plane) {
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const ClipPoint &a = points[i], &b = points[(i + 1) % count];
      const double d_a = distance(job, a, plane), d_b = distance(job, b, plane);
      if (d_a >= 0.0) kept[left++] = a;
      if ((d_a >= 0.0) != (d_b >= 0.0))
        kept[left++] = d_a >= 0.0 ? crossing(a, b, d_a, d_b) : crossing(b, a, d_b, d_a);
    }
    std::copy(kept, kept + left, points);
    count = left;
  }
  polygon.count = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (!(points[i].w > 0.0)) return {};
    polygon.points[polygon.count++] = onScreen(job, points[i]);
  }
  return polygon;
}

}  // namespace furrow

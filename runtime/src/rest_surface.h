#pragma once

// What follows from the surface at rest: rings, coefficients and normals of the points. No asset holds them:
// the loader works them out, and the cook does so with the same code. Only operations that IEEE 754 rounds
// exactly take part, so that they come out with the same bits on every machine.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "furrow/asset.h"
#include "furrow/types.h"

namespace furrow {

struct RestSurface {
  std::span<const Float3> points;          // where a point rests, in root space; finite
  std::span<const uint32_t> indices;       // 3 a triangle, vertices
  std::span<const uint32_t> vertex_point;  // a vertex, < points.size()

  size_t triangleCount() const { return indices.size() / 3; }
  uint32_t corner(size_t triangle, size_t c) const { return vertex_point[indices[3 * triangle + c]]; }
};

// Whether a triangle is more than 2000 times as long as high, so that its height is the rounding of its
// corners.
bool isNeedle(Float3 a, Float3 b, Float3 c);

// Whether a triangle is no measure of anything: two corners are one point, or it is a needle.
bool isDegenerate(const RestSurface& surface, size_t triangle);

// Point p's triangles are triangles[offsets[p]] to triangles[offsets[p + 1]], ascending, with the shares of
// their angles there as unorm16 that sum to exactly 65535. Degenerate triangles are in no ring.
struct Rings {
  std::vector<uint32_t> offsets;
  std::vector<uint32_t> triangles;
  std::vector<uint16_t> weights;
};
Rings makeRings(const RestSurface& surface);

// Of each point: the sum of its triangles' normals, weighted by area, as a unit vector; +Y where it has none.
std::vector<Float3> pointNormals(const RestSurface& surface);

// The numbers that triangles [begin, end) are measured with, into out[begin * coefficientCount(measure)] and
// on. All zero: the triangle is in no ring of the layer; degenerate ones are, those whose direction is
// undefined, and those too small for a float.
//   directional  c1, c2 with c1 e1 + c2 e2 = u, the line-field mean of the corners' directions in the
//                triangle's plane [Larsson]
//   area         1 / (2 A0)
//   principal    the inverse of the rest edges in the triangle's frame: 1/a, -b/(a c), 1/c for e1 = (a, 0),
//                e2 = (b, c)
// `directions`: a point, unit or zero; read for directional alone.
void makeCoefficients(const RestSurface& surface, Measure measure, std::span<const Float3> directions,
                      size_t begin, size_t end, std::span<float> out);

// Shares of the values' sum as unorm16 that sum to exactly 65535 (largest remainder); equal shares where the
// sum is 0.
class UnitShares {
 public:
  void operator()(std::span<const float> values, std::span<uint16_t> out);

 private:
  std::vector<std::pair<double, size_t>> remainders_;
};

}  // namespace furrow

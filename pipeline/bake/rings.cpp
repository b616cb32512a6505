#include "pipeline/bake/rings.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "pipeline/pack/geometry.h"

namespace furrow::pipeline {
namespace {

constexpr double kThinnest = 1.0 / 2000.0;  // height of a triangle over its longest edge

}  // namespace

bool isDegenerate(const Surface& surface, size_t triangle) {
  const glm::uvec3 p = surface.trianglePoints(triangle);
  if (p.x == p.y || p.y == p.z || p.z == p.x) return true;
  const glm::dvec3 a = surface.point_positions[p.x], b = surface.point_positions[p.y],
                   c = surface.point_positions[p.z];
  const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  return !(glm::length(glm::cross(b - a, c - a)) > kThinnest * longest);
}

Rings makeRings(const Surface& surface) {
  Rings rings;
  rings.offsets.assign(surface.point_positions.size() + 1, 0);
  std::vector<bool> skip(surface.triangles.size());
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    skip[t] = isDegenerate(surface, t);
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; !skip[t] && c < 3; ++c) ++rings.offsets[p[c] + 1];
  }
  std::partial_sum(rings.offsets.begin(), rings.offsets.end(), rings.offsets.begin());
  rings.triangles.resize(rings.offsets.back());
  rings.weights.resize(rings.offsets.back());
  std::vector<double> angles(rings.offsets.back());
  std::vector<uint32_t> next(rings.offsets.begin(), rings.offsets.end() - 1);
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    if (skip[t]) continue;
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3 at = surface.point_positions[p[c]];
      const glm::dvec3 e = glm::dvec3(surface.point_positions[p[(c + 1) % 3]]) - at;
      const glm::dvec3 f = glm::dvec3(surface.point_positions[p[(c + 2) % 3]]) - at;
      const uint32_t entry = next[p[c]]++;
      rings.triangles[entry] = static_cast<uint32_t>(t);
      angles[entry] = std::atan2(glm::length(glm::cross(e, f)), glm::dot(e, f));
    }
  }
  for (size_t p = 0; p + 1 < rings.offsets.size(); ++p) {
    const uint32_t begin = rings.offsets[p];
    const uint32_t count = rings.offsets[p + 1] - begin;
    quantizeUnitSum({&angles[begin], count}, {&rings.weights[begin], count});
  }
  return rings;
}

}  // namespace furrow::pipeline

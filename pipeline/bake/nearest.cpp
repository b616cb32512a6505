#include "pipeline/bake/nearest.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <unsupported/Eigen/BVH>

#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {
namespace {

Eigen::Vector3d eigen(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}

struct Triangle {
  size_t index;
  std::array<glm::dvec3, 3> corners;
};

Eigen::AlignedBox3d bounding_box(const Triangle& triangle) {
  const auto& [a, b, c] = triangle.corners;
  return {eigen(glm::min(a, glm::min(b, c))), eigen(glm::max(a, glm::max(b, c)))};
}

// Barycentric coordinates of the triangle's place nearest to p [Ericson, Real-Time Collision
// Detection, 5.1.5].
glm::dvec3 nearestPlace(const Triangle& triangle, glm::dvec3 p) {
  const auto& [a, b, c] = triangle.corners;
  const glm::dvec3 ab = b - a, ac = c - a;
  const double d1 = glm::dot(ab, p - a), d2 = glm::dot(ac, p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = glm::dot(ab, p - b), d4 = glm::dot(ac, p - b);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  const double d5 = glm::dot(ab, p - c), d6 = glm::dot(ac, p - c);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0, 1.0 - w, w};
  }
  return glm::dvec3(va, vb, vc) / (va + vb + vc);
}

struct Search {
  using Scalar = double;
  glm::dvec3 p;
  double best = INFINITY;
  NearestTriangle::Found found = {};

  double minimumOnVolume(const Eigen::AlignedBox3d& box) const {
    return box.squaredExteriorDistance(eigen(p));
  }
  double minimumOnObject(const Triangle& object) {
    const glm::dvec3 place = nearestPlace(object, p);
    const auto& [a, b, c] = object.corners;
    const glm::dvec3 away = a * place.x + b * place.y + c * place.z - p;
    const double square = glm::dot(away, away);
    if (square < best) {
      best = square;
      found = {object.index, place, std::sqrt(square)};
    }
    return square;
  }
};

}  // namespace

struct NearestTriangle::Tree : Eigen::KdBVH<double, 3, Triangle> {
  using Eigen::KdBVH<double, 3, Triangle>::KdBVH;
};

NearestTriangle::NearestTriangle(const Surface& surface, const std::vector<bool>& covered) {
  std::vector<Triangle> triangles;
  double edges = 0.0;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    if (!covered[t] || isDegenerate(restView(surface), t)) continue;
    Triangle& triangle = triangles.emplace_back(Triangle{t, {}});
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; c < 3; ++c) triangle.corners[c] = surface.point_positions[p[c]];
    for (int c = 0; c < 3; ++c) edges += glm::distance(triangle.corners[c], triangle.corners[(c + 1) % 3]);
  }
  if (triangles.empty()) throw std::runtime_error("its surface has no area");
  mean_edge_ = edges / (3.0 * static_cast<double>(triangles.size()));
  tree_ = std::make_unique<Tree>(triangles.begin(), triangles.end());
}

NearestTriangle::~NearestTriangle() = default;

NearestTriangle::Found NearestTriangle::find(glm::dvec3 p) const {
  Search search{p};
  Eigen::BVMinimize(*tree_, search);
  return search.found;
}

}  // namespace furrow::pipeline

#include "pipeline/bake/nearest.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <stdexcept>
#include <unsupported/Eigen/BVH>
#include <utility>

#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {
namespace {

Eigen::Vector3d eigen(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}

constexpr size_t kRun = 16;  // triangles in one leaf of the tree

using Triangle = std::array<glm::dvec3, 3>;

Triangle cornersOf(const Surface& surface, size_t triangle) {
  const glm::uvec3 p = surface.trianglePoints(triangle);
  return {surface.point_positions[p.x], surface.point_positions[p.y], surface.point_positions[p.z]};
}

}  // namespace

glm::dvec3 nearestPlace(const std::array<glm::dvec3, 3>& triangle, glm::dvec3 p) {
  const auto& [a, b, c] = triangle;
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
  const double sum = va + vb + vc;
  return sum > 0.0 ? glm::dvec3(va, vb, vc) / sum : glm::dvec3(1.0, 0.0, 0.0);
}

// Over runs of triangles that lie together: 13 bytes a triangle.
class NearestTriangle::Tree {
 public:
  Tree(const Surface& surface, std::vector<uint32_t> triangles)
      : surface_(surface), triangles_(std::move(triangles)) {
    sort();
    std::vector<uint32_t> runs;
    std::vector<Eigen::AlignedBox3d> boxes;
    for (size_t begin = 0; begin < triangles_.size(); begin += kRun) {
      runs.push_back(static_cast<uint32_t>(begin));
      Eigen::AlignedBox3d& box = boxes.emplace_back();
      for (const uint32_t t : run(runs.back()))
        for (const glm::dvec3& corner : cornersOf(surface_, t)) box.extend(eigen(corner));
    }
    runs_.init(runs.begin(), runs.end(), boxes.begin(), boxes.end());
  }

  Found find(glm::dvec3 p) const {
    Search search{*this, p};
    Eigen::BVMinimize(runs_, search);
    return search.found;
  }

 private:
  struct Search {
    using Scalar = double;
    const Tree& tree;
    glm::dvec3 p;
    double best = INFINITY;
    Found found = {};

    double minimumOnVolume(const Eigen::AlignedBox3d& box) const {
      return box.squaredExteriorDistance(eigen(p));
    }
    double minimumOnObject(uint32_t begin) {
      for (const uint32_t t : tree.run(begin)) {
        const Triangle triangle = cornersOf(tree.surface_, t);
        const glm::dvec3 place = nearestPlace(triangle, p);
        const glm::dvec3 away = triangle[0] * place.x + triangle[1] * place.y + triangle[2] * place.z - p;
        const double square = glm::dot(away, away);
        if (square >= best) continue;
        best = square;
        found = {t, place, std::sqrt(square)};
      }
      return best;
    }
  };

  std::span<const uint32_t> run(size_t begin) const {
    return std::span(triangles_).subspan(begin, std::min(kRun, triangles_.size() - begin));
  }

  void sort() {
    std::vector<glm::vec3> middles;
    middles.reserve(triangles_.size());
    for (const uint32_t t : triangles_) {
      const auto [a, b, c] = cornersOf(surface_, t);
      middles.emplace_back((a + b + c) / 3.0);
    }
    std::vector<uint32_t> place(triangles_.size()), sorted(triangles_.size());
    meshopt_spatialSortRemap(place.data(), &middles[0].x, middles.size(), sizeof(glm::vec3));
    for (size_t i = 0; i < sorted.size(); ++i) sorted[place[i]] = triangles_[i];
    triangles_ = std::move(sorted);
  }

  const Surface& surface_;
  std::vector<uint32_t> triangles_;
  Eigen::KdBVH<double, 3, uint32_t> runs_;  // by their first triangle
};

NearestTriangle::NearestTriangle(const Surface& surface, const std::vector<bool>& covered) {
  std::vector<uint32_t> triangles;
  for (uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (covered[t] && !isDegenerate(restView(surface), t)) triangles.push_back(t);
  if (triangles.empty()) throw std::runtime_error("its surface has no area");
  double edges = 0.0;
  for (const uint32_t t : triangles) {
    const auto [a, b, c] = cornersOf(surface, t);
    edges += glm::distance(a, b) + glm::distance(b, c) + glm::distance(c, a);
  }
  mean_edge_ = edges / (3.0 * static_cast<double>(triangles.size()));
  tree_ = std::make_unique<Tree>(surface, std::move(triangles));
}

NearestTriangle::~NearestTriangle() = default;

NearestTriangle::Found NearestTriangle::find(glm::dvec3 p) const {
  return tree_->find(p);
}

}  // namespace furrow::pipeline

#include "pipeline/bake/line_field.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/bake/intrinsic_delaunay.h"
#include "pipeline/bake/multigrid.h"
#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {
namespace {

using Complex = LineField::Complex;

constexpr double kReach = 0.25;    // of the covered surface's size
constexpr double kMostCot = 10.0;  // of slivers
constexpr double kUnknown = 1e-6;  // |z| below it is rounding

using EdgeWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Half the sum of the cotangents of an edge's two angles, in the upper triangle.
EdgeWeights cotangentWeights(std::vector<IntrinsicTriangle> triangles, int count) {
  makeDelaunay(triangles);
  std::vector<Eigen::Triplet<double>> cotangents;
  cotangents.reserve(3 * triangles.size());
  for (const IntrinsicTriangle& triangle : triangles)
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(triangle.corners[(c + 1) % 3], triangle.corners[(c + 2) % 3]);
      if (low != high)
        cotangents.push_back({static_cast<int>(low), static_cast<int>(high), 0.5 * triangle.cotangent(c)});
    }
  triangles = {};
  EdgeWeights edges(count, count);
  edges.setFromTriplets(cotangents.begin(), cotangents.end());
  return edges;
}

}  // namespace

LineField::Frame LineField::frameOf(glm::dvec3 n) {
  const glm::dvec3 helper = std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, n));
  return {x, glm::cross(n, x), n};
}

// By the least rotation between the normals.
glm::dvec3 LineField::turned(glm::dvec3 v, glm::dvec3 from_normal, glm::dvec3 to_normal) {
  const glm::dvec3 axis = glm::cross(from_normal, to_normal);
  const double c = glm::dot(from_normal, to_normal);
  return c > -0.999 ? c * v + glm::cross(axis, v) + axis * (glm::dot(axis, v) / (1.0 + c)) : v;
}

LineField::LineField(const Surface& surface, const std::vector<bool>& covered)
    : surface_(surface), covered_(covered), unknown_(surface.point_positions.size(), -1) {
  double total = 0.0;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    if (!covered[t]) continue;
    const glm::uvec3 p = surface.trianglePoints(t);
    const glm::dvec3 a = surface.point_positions[p.x];
    const double area = 0.5 * glm::length(glm::cross(glm::dvec3(surface.point_positions[p.y]) - a,
                                                     glm::dvec3(surface.point_positions[p.z]) - a));
    total += area;
    for (int c = 0; c < 3; ++c) {
      int& number = unknown_[p[c]];
      if (number < 0) {
        number = static_cast<int>(point_.size());
        point_.push_back(p[c]);
        frames_.push_back(frameOf(surface.point_normals[p[c]]));
        area_.push_back(0.0);
      }
      area_[number] += area / 3.0;
    }
  }
  pull_.resize(point_.size());
  pull_weight_.resize(point_.size());
  size_ = std::sqrt(total);
  reach_ = kReach * size_;
}

void LineField::add(size_t triangle, glm::dvec3 barycentric, Complex line, double weight) {
  const glm::uvec3 v = surface_.triangles[triangle], p = surface_.trianglePoints(triangle);
  const TriangleFrame frame =
      triangleFrame(surface_.positions[v.x], surface_.positions[v.y], surface_.positions[v.z]);
  const glm::dvec3 normal = glm::cross(frame.x, frame.y);
  for (int c = 0; c < 3; ++c) {
    const int i = unknown_[p[c]];
    const glm::dvec3 x = turned(frame.x, normal, frames_[i].normal);
    const Complex turn(glm::dot(x, frames_[i].x), glm::dot(x, frames_[i].y));
    pull_[i] += barycentric[c] * weight * (turn * turn) * line;
    pull_weight_[i] += barycentric[c] * weight;
  }
}

DirectionField LineField::solve() const {
  const int count = static_cast<int>(point_.size());
  std::vector<IntrinsicTriangle> triangles;
  for (size_t t = 0; t < surface_.triangles.size(); ++t) {
    if (!covered_[t] || isDegenerate(restView(surface_), t)) continue;
    const glm::uvec3 p = surface_.trianglePoints(t);
    IntrinsicTriangle& triangle = triangles.emplace_back();
    for (int c = 0; c < 3; ++c) {
      triangle.corners[c] = static_cast<uint32_t>(unknown_[p[c]]);
      triangle.lengths[c] = glm::distance(glm::dvec3(surface_.point_positions[p[(c + 1) % 3]]),
                                          glm::dvec3(surface_.point_positions[p[(c + 2) % 3]]));
    }
  }
  EdgeWeights edges = cotangentWeights(std::move(triangles), count);

  std::vector<Eigen::Triplet<Complex>> entries;
  entries.reserve(2 * static_cast<size_t>(edges.nonZeros()) + point_.size());
  std::vector<double> diagonal = pull_weight_;
  for (int i = 0; i < count; ++i)
    diagonal[i] += std::max(area_[i], 1e-12 * size_ * size_) / (reach_ * reach_);
  for (int i = 0; i < edges.outerSize(); ++i)
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator edge(edges, i); edge; ++edge) {
      const int j = static_cast<int>(edge.col());
      const double weight = std::clamp(edge.value(), 0.0, kMostCot);
      const glm::dvec3 x = turned(frames_[j].x, frames_[j].normal, frames_[i].normal);
      const Complex turn(glm::dot(x, frames_[i].x), glm::dot(x, frames_[i].y));
      const double length = std::norm(turn);
      const Complex r = length > 1e-12 ? turn * turn / length : Complex(1.0, 0.0);
      entries.push_back({i, j, -weight * r});
      entries.push_back({j, i, -weight * std::conj(r)});
      diagonal[i] += weight;
      diagonal[j] += weight;
    }
  for (int i = 0; i < count; ++i) entries.push_back({i, i, Complex(diagonal[i], 0.0)});
  edges = {};
  HermitianMatrix matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  entries = {};
  const Eigen::VectorXcd z = solveMultigrid(matrix, Eigen::VectorXcd::Map(pull_.data(), count));

  DirectionField field;
  field.direction.assign(unknown_.size(), glm::vec3(0.0f));
  field.confidence.assign(unknown_.size(), 0.0f);
  for (int i = 0; i < count; ++i) {
    const Frame& frame = frames_[i];
    const double length = std::abs(z[i]);
    const bool known = std::isfinite(length) && length > kUnknown;
    // Up, where nothing is known.
    const Complex up(frame.x.y, frame.y.y), line = known ? z[i] : up * up;
    const double angle = 0.5 * std::arg(line);
    field.direction[point_[i]] = glm::vec3(std::cos(angle) * frame.x + std::sin(angle) * frame.y);
    if (known) field.confidence[point_[i]] = static_cast<float>(std::min(1.0, length));
  }
  return field;
}

}  // namespace furrow::pipeline

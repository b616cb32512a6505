#include "pipeline/bake/line_field.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "pipeline/bake/rest_view.h"
#include "pipeline/release.h"

namespace furrow::pipeline {
namespace {

using Complex = LineField::Complex;

constexpr double kReach = 0.25;       // of the covered surface's size
constexpr double kMostWeight = 10.0;  // of an edge at slivers
constexpr double kUnknown = 1e-6;     // |z| below it is rounding

struct Edge {
  uint32_t a, b;
  float weight;  // half the sum of the cotangents of the two angles that face it
};

std::vector<Edge> weighedEdges(std::vector<IntrinsicTriangle> triangles) {
  const std::vector<uint32_t> twins = makeDelaunay(triangles);
  std::vector<Edge> edges;
  edges.reserve(2 * triangles.size());
  for (uint32_t side = 0; side < twins.size(); ++side) {
    const IntrinsicTriangle& triangle = triangles[side / 3];
    const uint32_t twin = twins[side], a = triangle.corners[(side + 1) % 3],
                   b = triangle.corners[(side + 2) % 3];
    if (twin < side || a == b) continue;
    double cotangents = triangle.cotangent(side % 3);
    if (twin != kNoSide) cotangents += triangles[twin / 3].cotangent(twin % 3);
    edges.push_back({a, b, static_cast<float>(std::clamp(0.5 * cotangents, 0.0, kMostWeight))});
  }
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
    const Frame at = frameOf(surface_.point_normals[p[c]]);
    const glm::dvec3 x = turned(frame.x, normal, at.normal);
    const Complex turn(glm::dot(x, at.x), glm::dot(x, at.y));
    pull_[i] += barycentric[c] * weight * (turn * turn) * line;
    pull_weight_[i] += barycentric[c] * weight;
  }
}

// Of the covered triangles, with unknowns as points.
std::vector<IntrinsicTriangle> LineField::intrinsicTriangles() const {
  std::vector<IntrinsicTriangle> triangles;
  triangles.reserve(static_cast<size_t>(std::ranges::count(covered_, true)));
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
  return triangles;
}

Equations LineField::equations() const {
  const std::vector<Edge> edges = weighedEdges(intrinsicTriangles());
  const size_t count = point_.size();
  Equations a;
  a.begins.assign(count + 1, 0);
  for (const Edge& edge : edges) {
    ++a.begins[edge.a];
    ++a.begins[edge.b];
  }
  std::partial_sum(a.begins.begin(), a.begins.end(), a.begins.begin());
  a.entries.resize(2 * edges.size());
  a.diagonal.resize(count);
  for (size_t i = 0; i < count; ++i)
    a.diagonal[i] = pull_weight_[i] + std::max(area_[i], 1e-12 * size_ * size_) / (reach_ * reach_);
  for (const auto& [i, j, weight] : edges) {
    const Frame to = frameOf(surface_.point_normals[point_[i]]),
                from = frameOf(surface_.point_normals[point_[j]]);
    const glm::dvec3 x = turned(from.x, from.normal, to.normal);
    const Complex turn(glm::dot(x, to.x), glm::dot(x, to.y));
    const double length = std::norm(turn);
    const Complex entry = -double{weight} * (length > 1e-12 ? turn * turn / length : Complex(1.0, 0.0));
    const std::complex<float> rounded(static_cast<float>(entry.real()), static_cast<float>(entry.imag()));
    a.entries[--a.begins[i]] = {j, rounded};
    a.entries[--a.begins[j]] = {i, std::conj(rounded)};
    const double stored = std::abs(Complex(rounded));  // so that rounding adds nothing to the small diagonal
    a.diagonal[i] += stored;
    a.diagonal[j] += stored;
  }
  for (size_t i = 0; i < count; ++i)
    std::sort(a.entries.begin() + a.begins[i], a.entries.begin() + a.begins[i + 1],
              [](const auto& one, const auto& other) { return one.column < other.column; });
  return a;
}

DirectionField LineField::solve() && {
  const Equations a = equations();
  release(area_, pull_weight_);
  const std::vector<Complex> z = solveMultigrid(a, std::move(pull_));

  DirectionField field;
  field.direction.assign(unknown_.size(), glm::vec3(0.0f));
  field.confidence.assign(unknown_.size(), 0.0f);
  for (size_t i = 0; i < z.size(); ++i) {
    const Frame frame = frameOf(surface_.point_normals[point_[i]]);
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

#include "pipeline/bake/directions.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>

namespace furrow::pipeline {
namespace {

using Complex = std::complex<double>;

constexpr double kPull = 4.0;        // of a fully confident measurement, against 1 for an edge of the surface
constexpr double kLeastPull = 1e-9;  // keeps the matrix definite where nothing was measured

struct Frame {
  glm::dvec3 x, y;
};

Frame frameOf(glm::dvec3 n) {
  const glm::dvec3 helper = std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, n));
  return {x, glm::cross(n, x)};
}

// A line in a frame as a complex number with twice its angle, so that d and -d are one.
Complex doubled(const Frame& frame, glm::dvec3 d) {
  const Complex z(glm::dot(d, frame.x), glm::dot(d, frame.y));
  return z * z;
}

glm::vec3 line(const Frame& frame, Complex z) {
  const double angle = 0.5 * std::arg(z);
  return glm::vec3(std::cos(angle) * frame.x + std::sin(angle) * frame.y);
}

glm::vec3 projected(glm::dvec3 axis, glm::dvec3 n) {
  const glm::dvec3 d = axis - glm::dot(axis, n) * n;
  const double length = glm::length(d);
  return length > 1e-6 ? glm::vec3(d / length) : glm::vec3(0.0f);
}

// Turns a doubled line of frame `from` into frame `to` by the least rotation between their normals.
Complex transport(const Frame& from, glm::dvec3 from_normal, const Frame& to, glm::dvec3 to_normal) {
  const glm::dvec3 axis = glm::cross(from_normal, to_normal);
  const double c = glm::dot(from_normal, to_normal);
  glm::dvec3 x = from.x;
  if (c > -0.999) x = c * x + glm::cross(axis, x) + axis * (glm::dot(axis, x) / (1.0 + c));
  const Complex z = doubled(to, x);
  const double length = std::abs(z);
  return length > 1e-12 ? z / length : Complex(1.0, 0.0);
}

}  // namespace

DirectionField directionsFromAxis(const Surface& surface, glm::dvec3 axis) {
  DirectionField field;
  for (const glm::vec3& normal : surface.point_normals) {
    field.direction.push_back(projected(axis, normal));
    field.confidence.push_back(field.direction.back() == glm::vec3(0.0f) ? 0.0f : 1.0f);
  }
  return field;
}

DirectionField directionsFromVectors(const Surface& surface, const std::vector<glm::vec3>& vectors) {
  std::vector<Complex> sum(surface.point_positions.size());
  std::vector<double> total(sum.size());
  std::vector<Frame> frames;
  for (const glm::vec3& normal : surface.point_normals) frames.push_back(frameOf(normal));
  for (size_t v = 0; v < vectors.size(); ++v) {
    const uint32_t p = surface.vertex_point[v];
    const glm::vec3 d = projected(vectors[v], surface.point_normals[p]);
    if (d == glm::vec3(0.0f)) continue;
    sum[p] += doubled(frames[p], d);
    total[p] += 1.0;
  }
  DirectionField field;
  for (size_t p = 0; p < sum.size(); ++p) {
    const double agreement = total[p] > 0.0 ? std::abs(sum[p]) / total[p] : 0.0;
    field.direction.push_back(agreement > 1e-6 ? line(frames[p], sum[p]) : glm::vec3(0.0f));
    field.confidence.push_back(static_cast<float>(agreement));
  }
  return field;
}

DirectionField directionsFromSqueeze(const Surface& surface, const Squeeze& squeeze) {
  const size_t points = surface.point_positions.size();
  std::vector<Frame> frames;
  for (const glm::vec3& normal : surface.point_normals) frames.push_back(frameOf(normal));

  // The anisotropy of every triangle's tensor, area-weighted, at its corners.
  std::vector<Complex> measured(points);
  std::vector<double> area(points);
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const glm::uvec3 corners = surface.triangles[t];
    const TriangleFrame frame = triangleFrame(surface.positions[corners.x], surface.positions[corners.y],
                                              surface.positions[corners.z]);
    const double weight = 0.5 * frame.e1x * frame.e2y;
    const glm::dvec3 tensor = squeeze.tensor[t];
    const Complex z(tensor.x - tensor.z, 2.0 * tensor.y);
    const double half_angle = 0.5 * std::arg(z);
    const glm::dvec3 d = std::cos(half_angle) * frame.x + std::sin(half_angle) * frame.y;
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; c < 3; ++c) {
      measured[p[c]] += weight * std::abs(z) * doubled(frames[p[c]], d);
      area[p[c]] += weight;
    }
  }
  std::vector<double> strength(points);
  for (size_t p = 0; p < points; ++p) strength[p] = area[p] > 0.0 ? std::abs(measured[p]) / area[p] : 0.0;
  std::vector<double> squeezed;
  for (double s : strength)
    if (s > 0.0) squeezed.push_back(s);
  double typical = 1.0;
  if (!squeezed.empty()) {
    const size_t at = squeezed.size() * 3 / 4;
    std::nth_element(squeezed.begin(), squeezed.begin() + at, squeezed.end());
    typical = 0.5 * squeezed[at];
  }

  // An edge once a triangle, so that inner edges count twice and border edges once.
  std::vector<Eigen::Triplet<Complex>> entries;
  entries.reserve(surface.triangles.size() * 6 + points);
  std::vector<double> diagonal(points, kLeastPull);
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const glm::uvec3 p = surface.trianglePoints(t);
    for (int c = 0; c < 3; ++c) {
      const uint32_t i = p[c], j = p[(c + 1) % 3];
      if (i == j) continue;
      const Complex r =
          0.5 * transport(frames[j], surface.point_normals[j], frames[i], surface.point_normals[i]);
      entries.push_back({static_cast<int>(i), static_cast<int>(j), -r});
      entries.push_back({static_cast<int>(j), static_cast<int>(i), -std::conj(r)});
      diagonal[i] += 0.5;
      diagonal[j] += 0.5;
    }
  }
  Eigen::VectorXcd right(points), guess(points);
  for (size_t p = 0; p < points; ++p) {
    const double length = std::abs(measured[p]);
    const double pull = kPull * strength[p] / (strength[p] + typical);
    guess[p] = length > 0.0 ? measured[p] / length : Complex(0.0, 0.0);
    right[p] = pull * guess[p];
    entries.push_back({static_cast<int>(p), static_cast<int>(p), Complex(diagonal[p] + pull, 0.0)});
  }
  Eigen::SparseMatrix<Complex, Eigen::RowMajor> matrix(points, points);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<Complex, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(1e-4);
  solver.setMaxIterations(300);
  solver.compute(matrix);
  const Eigen::VectorXcd solution = solver.solveWithGuess(right, guess);

  DirectionField field;
  for (size_t p = 0; p < points; ++p) {
    const Complex z = solution[p];
    const bool known = std::isfinite(z.real()) && std::isfinite(z.imag()) && std::abs(z) > 1e-12;
    glm::vec3 d = known ? line(frames[p], z) : projected({0, 1, 0}, surface.point_normals[p]);
    if (d == glm::vec3(0.0f)) d = glm::vec3(frames[p].x);
    field.direction.push_back(d);
    field.confidence.push_back(known ? static_cast<float>(std::min(1.0, std::abs(z))) : 0.0f);
  }
  return field;
}

}  // namespace furrow::pipeline

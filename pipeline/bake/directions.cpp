#include "pipeline/bake/directions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <utility>

#include "direction_codec.h"
#include "pipeline/bake/nearest.h"
#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {
namespace {

using Complex = LineField::Complex;

constexpr double kDetail = 0.02;       // of the surface's size: evidence is smoothed over it
constexpr double kGuidePull = 100.0;   // of a curve, against the reach of the field
constexpr double kFarGuide = 0.1;      // of the surface's size
constexpr double kMostSamples = 4096;  // of a segment

void addGuides(const Surface& surface, const NearestTriangle& nearest,
               std::span<const std::array<glm::dvec3, 2>> segments, LineField& field) {
  const auto find = [&](glm::dvec3 p) {
    const auto found = nearest.find(p);
    if (found.distance > kFarGuide * field.size()) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "a guide curve at (%g, %g, %g) is %.3g from its surface, which is %.3g across", p.x, p.y,
                    p.z, found.distance, field.size());
      throw std::runtime_error(text);
    }
    return found;
  };
  const double step = 0.5 * nearest.meanEdge();
  double length = 0.0;
  for (const auto& [begin, end] : segments) {
    find(begin);
    find(end);
    const double whole = glm::distance(begin, end);
    length += whole;
    const double samples = std::clamp(std::ceil(whole / step), 1.0, kMostSamples);
    for (double i = 0.5; i < samples; ++i) {
      const auto at = find(begin + (end - begin) * (i / samples));
      const glm::uvec3 v = surface.triangles[at.triangle];
      const TriangleFrame frame =
          triangleFrame(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
      const Complex along(glm::dot(end - begin, frame.x), glm::dot(end - begin, frame.y));
      const double square = std::norm(along);
      if (square > 1e-12 * whole * whole)  // across is along turned by a quarter, so doubled by a half
        field.add(at.triangle, at.barycentric, -along * along / square,
                  kGuidePull / field.reach() * whole / samples);
    }
  }
  if (!(length > 1e-9 * field.size())) throw std::runtime_error("its guide curves have no length");
}

}  // namespace

DirectionField directionsFromAxis(const Surface& surface, glm::vec3 axis) {
  DirectionField field;
  std::vector<Float3> directions;
  projectAxis(asFloat3(surface.point_normals), {axis.x, axis.y, axis.z}, directions, field.confidence);
  for (const Float3& d : directions) field.direction.push_back({d.x, d.y, d.z});
  return field;
}

DirectionField directionsFromTensors(const Surface& surface, const std::vector<bool>& covered,
                                     const LineTensors& tensors) {
  LineField field(surface, covered);
  const auto areaOf = [&](size_t t) {
    const glm::uvec3 v = surface.triangles[t];
    const TriangleFrame frame =
        triangleFrame(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
    return 0.5 * frame.e1x * frame.e2y;
  };
  const auto traceOf = [&](size_t t) { return double{tensors[t].x} + double{tensors[t].z}; };
  double sum = 0.0, squares = 0.0;
  for (size_t t = 0; t < tensors.size(); ++t) {
    if (!covered[t]) continue;
    sum += areaOf(t) * traceOf(t);
    squares += areaOf(t) * traceOf(t) * traceOf(t);
  }
  const double typical = sum > 0.0 ? 0.5 * squares / sum : 1.0, detail = kDetail * field.size();
  for (size_t t = 0; t < tensors.size(); ++t) {
    const double trace = traceOf(t);
    if (!covered[t] || !(trace > 0.0) || isDegenerate(restView(surface), t)) continue;
    const glm::dvec3 tensor = tensors[t];
    const Complex line = Complex(tensor.x - tensor.z, 2.0 * tensor.y) / trace;
    field.add(t, glm::dvec3(1.0 / 3.0), line, areaOf(t) / (detail * detail) * trace / (trace + typical));
  }
  return std::move(field).solve();
}

LineTensors tensorsOfVectors(const Surface& surface, const std::vector<glm::vec3>& vectors) {
  LineTensors tensors(surface.triangles.size(), glm::vec3(0.0f));
  for (size_t t = 0; t < tensors.size(); ++t) {
    const glm::uvec3 v = surface.triangles[t];
    const TriangleFrame frame =
        triangleFrame(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3 d = vectors[v[c]];
      const double x = glm::dot(d, frame.x), y = glm::dot(d, frame.y), square = x * x + y * y;
      if (square > 1e-12 * glm::dot(d, d))
        tensors[t] += glm::vec3(x * x, x * y, y * y) / static_cast<float>(3.0 * square);
    }
  }
  return tensors;
}

DirectionField directionsFromGuides(const Surface& surface, const std::vector<bool>& covered,
                                    std::span<const std::array<glm::dvec3, 2>> segments) {
  LineField field(surface, covered);
  addGuides(surface, NearestTriangle(surface, covered), segments, field);
  return std::move(field).solve();
}

}  // namespace furrow::pipeline

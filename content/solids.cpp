#include "content/solids.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace furrow::content {

using glm::dvec3;

double ellipsoid(dvec3 p, dvec3 centre, dvec3 radii) {
  const dvec3 q = (p - centre) / radii;
  const double k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

double limb(dvec3 p, dvec3 a, dvec3 b, double radius_a, double radius_b) {
  const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
  return glm::distance(p, glm::mix(a, b, t)) - glm::mix(radius_a, radius_b, t);
}

double join(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * h * width / 6;
}

double carve(double a, double b, double width) {
  return -join(-a, b, width);
}

}  // namespace furrow::content

#include "pipeline/bake/coefficients.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/bake/rings.h"
#include "pipeline/bake/squeeze.h"

namespace furrow::pipeline {

std::vector<float> makeCoefficients(const Surface& surface, Measure measure,
                                    const std::vector<glm::vec3>& directions,
                                    const std::vector<bool>& covered) {
  const size_t each = coefficientCount(measure);
  std::vector<float> out(surface.triangles.size() * each, 0.0f);
  for (size_t t = 0; each > 0 && t < surface.triangles.size(); ++t) {
    if (!covered[t] || isDegenerate(surface, t)) continue;
    const glm::uvec3 p = surface.trianglePoints(t);
    const TriangleFrame frame = triangleFrame(surface.point_positions[p.x], surface.point_positions[p.y],
                                              surface.point_positions[p.z]);
    if (!(frame.e1x > 0.0) || !(frame.e2y > 0.0)) continue;
    float* c = &out[t * each];
    if (measure == Measure::kArea) {
      c[0] = static_cast<float>(1.0 / (frame.e1x * frame.e2y));
    } else if (measure == Measure::kPrincipal) {
      c[0] = static_cast<float>(1.0 / frame.e1x);
      c[1] = static_cast<float>(-frame.e2x / (frame.e1x * frame.e2y));
      c[2] = static_cast<float>(1.0 / frame.e2y);
    } else {
      double cos2 = 0.0, sin2 = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double x = glm::dot(glm::dvec3(directions[p[k]]), frame.x);
        const double y = glm::dot(glm::dvec3(directions[p[k]]), frame.y);
        cos2 += x * x - y * y;
        sin2 += 2.0 * x * y;
      }
      if (std::hypot(cos2, sin2) < 1e-3) continue;
      const double angle = 0.5 * std::atan2(sin2, cos2);
      const double c2 = std::sin(angle) / frame.e2y;
      c[0] = static_cast<float>((std::cos(angle) - c2 * frame.e2x) / frame.e1x);
      c[1] = static_cast<float>(c2);
    }
  }
  return out;
}

}  // namespace furrow::pipeline

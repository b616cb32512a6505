#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/constants.hpp>
#include <iterator>

#include "content/face_parts.h"
#include "content/head.h"

// A knitted collar that is rolled over at its edge, and the shirt from there over the shoulders: rings about
// the neck.

namespace furrow::content {

using glm::dvec2;
using glm::dvec3;

FacePart shirt() {
  constexpr double kPi = glm::pi<double>();
  constexpr uint32_t kSpokes = 88, kDown = 17;
  constexpr double kAxis = -8.3;
  // Of the collar: distance below its edge and height above the skin.
  constexpr dvec2 kRoll[] = {{1.0, 0.05}, {0.4, 0.08},  {0.1, 0.14}, {0.0, 0.26}, {0.06, 0.40}, {0.22, 0.50},
                             {0.5, 0.53}, {0.85, 0.53}, {1.2, 0.52}, {1.5, 0.48}, {1.62, 0.40}, {1.75, 0.33}};
  constexpr uint32_t kRings = std::size(kRoll) + kDown;
  FacePart part;
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const double turn = 2 * kPi * spoke / kSpokes - kPi;
      // Seen from within the neck, the edge lies deeper in front; the shoulders fan out below it.
      const double edge = -11.2 - 2.7 * (0.5 + 0.5 * std::cos(turn));
      const bool roll = ring < std::size(kRoll);
      const double t = roll ? 0 : static_cast<double>(ring + 1 - std::size(kRoll)) / kDown;
      const double fall = roll ? 0.35 : glm::mix(0.35, 1.22, std::pow(t, 0.8));
      const dvec3 from(0, edge + 2.0 - (roll ? kRoll[ring].x : kRoll[std::size(kRoll) - 1].x + 0.25 * t),
                       kAxis);
      const dvec3 out(std::sin(turn) * std::cos(fall), -std::sin(fall), std::cos(turn) * std::cos(fall));
      const double height = roll ? kRoll[ring].y : glm::mix(0.33, 0.42, t);
      const dvec3 p = head::trace(from + 34.0 * out, -out, height);
      part.addPoint(p, true, true);
      const double rib = roll && ring > 3 && ring < 10 ? 0.82 + 0.18 * std::cos(2 * kPi * spoke / 2) : 1.0;
      const double open = smoothRamp(0.0, 0.35, roll ? kRoll[ring].y : 0.4);
      part.colors.push_back(dvec3(0.050, 0.064, 0.088) * rib * glm::mix(0.35, 1.0, open));
    }
  }
  for (uint32_t ring = 0; ring < kRings; ++ring)
    for (uint32_t spoke = 0; spoke <= kSpokes; ++spoke)
      part.mesh.addVertex(ring * kSpokes + spoke % kSpokes,
                          {0.01 + 0.98 * spoke / kSpokes, 0.99 - 0.98 * ring / (kRings - 1)});
  for (uint32_t ring = 0; ring + 1 < kRings; ++ring) {
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const uint32_t a = ring * (kSpokes + 1) + spoke, b = a + kSpokes + 1;
      part.mesh.addQuad(a, b, b + 1, a + 1);
    }
  }
  part.materials.assign(part.mesh.triangles.size(), kShirt);
  return part;
}

}  // namespace furrow::content

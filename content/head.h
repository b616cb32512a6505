#pragma once

// The sculpted head as a signed distance, and the lines drawn on it. Centimetres; eyes at y = 0, facing +Z,
// the character's left at +X.

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace furrow::content::head {

inline constexpr glm::dvec3 kEye{3.15, 0.0, 0.05};           // centre of the left eyeball
inline constexpr double kEyeball = 1.32, kLid = 1.49;        // radii of the eyeball and of the lids' outside
inline constexpr double kEyeInner = 1.66, kEyeOuter = 4.66;  // x of the corners
inline constexpr double kMouth = 2.55;                       // x of the corner

double distance(glm::dvec3 p);
glm::dvec3 normal(glm::dvec3 p);

// The nearest surface, about; `offset` above it.
glm::dvec3 onto(glm::dvec3 p, int steps, double offset = 0.0);

// Where a ray meets the surface raised by `offset`; `direction` is a unit vector, the ray begins outside.
glm::dvec3 trace(glm::dvec3 from, glm::dvec3 direction, double offset = 0.0);

// Lid margins of the left eye at x: y of the upper and the lower one.
glm::dvec2 lidMargins(double x);
// y where the lips meet, and the borders of the upper and the lower lip, at x >= 0.
double lipLine(double x);
glm::dvec2 lipBorders(double x);

// The nasolabial fold of the left side: distance from it, positive on the cheek's side, and the unit
// direction across it, to the cheek.
struct Fold {
  double distance;
  glm::dvec2 across;
};
Fold nasolabialFold(glm::dvec2 p);

}  // namespace furrow::content::head

#pragma once

// Signed distances to model with: below 0 inside.

#include <glm/vec3.hpp>

namespace furrow::content {

double ellipsoid(glm::dvec3 p, glm::dvec3 centre, glm::dvec3 radii);  // about
// A limb whose radius goes from `radius_a` at a to `radius_b` at b.
double limb(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b, double radius_a, double radius_b);

// Union and difference, with a fillet about `width` wide [Quilez, smooth minimum, cubic].
double join(double a, double b, double width);
double carve(double a, double b, double width);

}  // namespace furrow::content

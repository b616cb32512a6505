#pragma once

// Direction fields from what an artist gives or the animation shows: d, ACROSS the creases, a point. What
// lies on no covered triangle stays zero, but for an axis.

#include <array>
#include <span>

#include "pipeline/bake/line_field.h"

namespace furrow::pipeline {

// `axis`, of any length but 0, projected into every point's tangent plane; confidence is the length of what
// is left.
DirectionField directionsFromAxis(const Surface& surface, glm::vec3 axis);

// What speaks for a direction in a triangle: the mean over it of w v v^T for lines v in its plane with
// weights w, as xx xy yy in triangleFrame(). The weights' scale does not matter, triangles with much outvote
// those with little, and lines that cross speak for nothing.
using LineTensors = std::vector<glm::vec3>;
DirectionField directionsFromTensors(const Surface& surface, const std::vector<bool>& covered,
                                     const LineTensors& tensors);

// Of vertices' vectors (root space; only their lines matter; zero: none).
LineTensors tensorsOfVectors(const Surface& surface, const std::vector<glm::vec3>& vectors);

// Curves drawn ALONG the creases on or near the covered surface, in root space at rest, as line segments.
// Diffused; confidence falls with the distance from them. Throws std::runtime_error, whose text says which
// place is too far from the surface or that the curves have no length.
DirectionField directionsFromGuides(const Surface& surface, const std::vector<bool>& covered,
                                    std::span<const std::array<glm::dvec3, 2>> segments);

}  // namespace furrow::pipeline

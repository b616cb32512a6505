#pragma once

// Direction fields: unit line fields per point, tangent to the surface.

#include <vector>

#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

struct DirectionField {
  std::vector<glm::vec3> direction;  // a point, unit; zero where undefined
  std::vector<float> confidence;     // a point, [0, 1]
};

// `axis` projected into every point's tangent plane; undefined where it is the normal.
DirectionField directionsFromAxis(const Surface& surface, glm::dvec3 axis);

// The line-field mean of the vertices' vectors (root space; zero: none) at each point.
DirectionField directionsFromVectors(const Surface& surface, const std::vector<glm::vec3>& vectors);

// The principal direction of the squeeze, smoothed as a line field over the surface: one sparse solve of the
// connection Laplacian with the measured directions as soft constraints, weighted by how much squeeze speaks
// for them [Knoeppel et al. 2013, n = 2].
DirectionField directionsFromSqueeze(const Surface& surface, const Squeeze& squeeze);

}  // namespace furrow::pipeline

#pragma once

// The numbers the runtime measures a triangle with, coefficientCount(measure) each.

#include <vector>

#include "furrow/asset.h"
#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// `directions`: a point, unit or zero; `covered`: a triangle, whether the layer has it. All zero: the
// triangle is in no ring of the layer.
//   directional  c1, c2 with c1 e1 + c2 e2 = u, the line-field mean of the corners' directions in the
//   triangle's plane [Larsson] area         1 / (2 A0) principal    the inverse of the rest edges in the
//   triangle's frame: 1/a, -b/(a c), 1/c for e1 = (a, 0), e2 = (b, c)
std::vector<float> makeCoefficients(const Surface& surface, Measure measure,
                                    const std::vector<glm::vec3>& directions,
                                    const std::vector<bool>& covered);

}  // namespace furrow::pipeline

#pragma once

// The surface as the runtime's rest_surface.h sees it.

#include "pipeline/bake/surface.h"
#include "rest_surface.h"

namespace furrow::pipeline {

static_assert(sizeof(glm::vec3) == sizeof(Float3) && sizeof(glm::uvec3) == 3 * sizeof(uint32_t));

inline std::span<const Float3> asFloat3(std::span<const glm::vec3> vectors) {
  return {reinterpret_cast<const Float3*>(vectors.data()), vectors.size()};
}

// Valid while `surface` is.
inline RestSurface restView(const Surface& surface) {
  return {asFloat3(surface.point_positions),
          {reinterpret_cast<const uint32_t*>(surface.triangles.data()), 3 * surface.triangles.size()},
          surface.vertex_point};
}

}  // namespace furrow::pipeline

#pragma once

// The posed surface on the CPU, for what the screen's picture cannot say: what lies under the pointer, and
// how far each place is squeezed now.

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "furrow/frame_plan.h"

namespace furrow::editor {

struct SurfaceHit {
  uint32_t triangle = 0;
  glm::vec3 barycentric{1, 0, 0};
  float distance = 0.0f;  // along the ray
};

class PosedSurface {
 public:
  // `asset` must outlive it.
  explicit PosedSurface(const AssetView& asset);

  void pose(const FrameInput& input);  // costs a deform

  const std::vector<Float3>& positions() const { return positions_; }  // relative to the frame's origin
  glm::vec3 at(uint32_t triangle, glm::vec3 barycentric) const;        // posed
  glm::vec3 restAt(uint32_t triangle, glm::vec3 barycentric) const;    // root space at rest
  glm::vec3 restNormal(uint32_t triangle) const;                       // of the facet, unit; 0 if degenerate

  // The nearest triangle that the ray meets, from either side.
  std::optional<SurfaceHit> hit(glm::vec3 eye, glm::vec3 direction) const;
  // The place whose rest position is nearest.
  SurfaceHit nearestAtRest(glm::vec3 rest) const;

  // Length along d over that at rest, sqrt(q), of every point whose ring a layer measures and whose mask is
  // above 0. `scale` is that of the frame.
  std::vector<float> stretches(uint32_t layer, float scale) const;

 private:
  const AssetView& asset_;
  std::vector<Float3> positions_;
  std::vector<glm::vec3> rest_;
};

}  // namespace furrow::editor

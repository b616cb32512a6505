#include "editor/preview/posed_frame.h"

#include <cmath>
#include <glm/vec4.hpp>

#include "furrow/drivers.h"

namespace furrow::preview {

PosedFrame poseFrame(const AssetView& asset, const pipeline::PosedRig& posed, std::span<const float> regions,
                     float scale) {
  PosedFrame frame;
  for (double weight : posed.morph_weights) frame.morph_weights.push_back(static_cast<float>(weight));
  frame.region_weights.assign(asset.layerCount(), 0.0f);
  driveRegions(asset, frame.morph_weights, regions, frame.region_weights);

  const Float3 p = asset.positions.front();
  const uint32_t entry = asset.joints.front();
  const glm::dvec4 origin = posed.palette[entry] * glm::dvec4(p.x, p.y, p.z, 1.0);
  for (int i = 0; i < 3; ++i) frame.origin[i] = std::isfinite(origin[i]) ? origin[i] : 0.0;
  for (const glm::dmat4& m : posed.palette) {
    Affine affine;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        affine.m[4 * row + column] =
            static_cast<float>(m[column][row] - (column == 3 ? frame.origin[row] : 0.0));
    frame.palette.push_back(affine);
  }
  frame.input.palette = frame.palette;
  frame.input.morph_weights = frame.morph_weights;
  frame.input.region_weights = frame.region_weights;
  frame.input.scale = scale;
  return frame;
}

}  // namespace furrow::preview

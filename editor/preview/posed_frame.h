#pragma once

// From the pose of a rig to what a frame is computed from.

#include <span>
#include <vector>

#include "furrow/frame_plan.h"
#include "pipeline/scene/rig.h"

namespace furrow::preview {

// `input` points into the vectors, which may be moved but not copied.
struct PosedFrame {
  std::vector<Affine> palette;
  std::vector<float> morph_weights, region_weights;
  double origin[3] = {};  // root space; palette translations are relative to it
  FrameInput input;

  PosedFrame() = default;
  PosedFrame(PosedFrame&&) = default;
  PosedFrame& operator=(PosedFrame&&) = default;
};

// Poses are computed about where the first vertex stands, so that a character far from the root keeps its
// precision. `regions`: scripted region weights, one a layer or none, to which the drivers' are added.
// `scale`: of the whole instance, which the pose contains.
PosedFrame poseFrame(const AssetView& asset, const pipeline::PosedRig& posed, std::span<const float> regions,
                     float scale);

}  // namespace furrow::preview

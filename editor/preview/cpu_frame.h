#pragma once

// A frame of the cpu tier, staged, with all that a picture needs.

#include <vector>

#include "editor/preview/stage_times.h"
#include "furrow/frame_plan.h"

namespace furrow::preview {

class CpuFrame {
 public:
  explicit CpuFrame(const AssetView& asset);  // `asset` must outlive the frame

  // Throws pipeline::Error (kBadUsage) for an input that does not fit the asset.
  void run(const FrameInput& input, StageTimes* times = nullptr);

  // A vertex, as the last run() left them; weights weightStride() a vertex.
  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
  std::vector<int16_t> weights;

 private:
  const AssetView& asset_;
  std::vector<float> triangle_q_, point_q_;
};

}  // namespace furrow::preview

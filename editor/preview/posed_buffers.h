#pragma once

// A posed and weighed surface in OpenGL buffers, by either way to it: the cpu tier's frame, uploaded, or a
// frame plan that OpenGL runs.

#include <array>
#include <memory>
#include <span>

#include "editor/preview/cpu_frame.h"
#include "editor/preview/gl_objects.h"
#include "furrow/frame_plan.h"
#include "furrow/gl/executor.h"
#include "furrow/gl/tier.h"

namespace furrow::preview {

// Names of buffers, a vertex, as FrameInput's outputs are: positions, normals, tangents, weights.
struct PosedBuffers {
  uint32_t positions = 0, normals = 0, tangents = 0, weights = 0;
  uint32_t layers = ~0u;  // bit by layer: 0: no vertex has a weight of it
};

// `asset` must outlive either.
class UploadedFrame {
 public:
  explicit UploadedFrame(const AssetView& asset);

  PosedBuffers run(const FrameInput& input, StageTimes* times);

 private:
  CpuFrame frame_;
  std::array<GlObject, 4> buffers_;
};

class GpuFrame {
 public:
  // Throws pipeline::Error where OpenGL cannot run it.
  GpuFrame(const AssetView& asset, gl::Tier tier, gl::ResetStatus lost);
  ~GpuFrame();
  GpuFrame(const GpuFrame&) = delete;
  GpuFrame& operator=(const GpuFrame&) = delete;

  // Fails where the context was lost.
  Status run(const FrameInput& input, StageTimes* times, PosedBuffers& out);

 private:
  FramePlan plan_;
  gl::Executor executor_;
  uint32_t generation_;
};

}  // namespace furrow::preview

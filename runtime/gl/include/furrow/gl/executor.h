#pragma once

// Runs a frame plan on OpenGL: 4.3 or newer for the compute forms, 3.3 for the raster form. All calls need
// the same current context; the functions are found through epoxy.

#include <functional>
#include <memory>
#include <span>

#include "furrow/frame_plan.h"
#include "furrow/gl/context.h"

namespace furrow::gl {

class Executor {
 public:
  Executor();
  ~Executor();  // needs the context, unless it was found lost or given up

  // Compiles the shaders and makes and fills the buffers. `plan` and the asset it was made from must outlive
  // the executor. Whether the context was lost is asked of `lost`; null: of resetStatus(). In either case
  // a context in which the executor's objects are no more is a lost one. Leaves no program, framebuffer and
  // pixel buffer bound.
  Status create(const FramePlan& plan, ResetStatus lost = nullptr);

  // Uploads an instance's kFrame and, unless posed by the host, kPalette and kMorphWeights. `input` must fit
  // the asset. kUnavailable where the context was lost: then nothing but the destructor may be called.
  Status upload(const FrameInput& input, uint32_t instance = 0);
  // `offset` + bytes: at most the buffer's size.
  void upload(Buffer buffer, std::span<const std::byte> bytes, uint64_t offset = 0);

  // Records every item; does not wait. In the clustered form, for `instances` alone (each at most once);
  // empty: for all. kUnavailable as for upload(). `recorded` is called behind the commands of every item: for
  // timer queries, say.
  //
  // Whatever state the host left is taken, and no state is restored. Every form leaves no program bound, and
  // its own buffers at the indexed uniform and storage slots of the plan. The raster form leaves no vertex
  // array, framebuffer and transform feedback buffer bound, texture unit 0 active and its textures at units
  // 0 to 4; off: blending, scissor, depth and stencil test, logic operation, primitive restart, clip
  // distances, program point size and the rasteriser's discarding; color mask all on, point size 1; viewport
  // and blend function its own.
  using Recorded = std::function<void(const Item&)>;
  Status run(std::span<const uint32_t> instances = {}, const Recorded& recorded = {});

  // The host found the context lost: nothing is deleted, and nothing but the destructor may be called.
  void giveUp();

  // Waits. In the raster form kPointQ is divided from the sums here.
  void read(Buffer buffer, std::span<std::byte> bytes, uint64_t offset = 0) const;
  uint32_t handle(Buffer buffer) const;  // OpenGL name, 0 if unused

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::gl

#pragma once

// The frame of one instance on whichever tier there is, for as long as there is one: where the OpenGL context
// is lost (a driver that was reset or updated, a GPU that was pulled, a context that was destroyed), the next
// frame runs on the next tier.

#include <memory>
#include <span>

#include "furrow/gl/executor.h"
#include "furrow/gl/tier.h"

namespace furrow::gl {

class TieredFrame {
 public:
  TieredFrame();
  ~TieredFrame();

  // `tier` from chooseTier(). `options` as for a plan of one instance that poses, without posed_by_host; the
  // form follows from the tier. `asset` must outlive the frame. Fails as Executor::create() does; then, and
  // before create(), only create() and the destructor may be called.
  Status create(const AssetView& asset, Tier tier, const PlanOptions& options = {},
                ResetStatus lost = nullptr);

  // One frame; `input` must fit the asset. kUnavailable where the context is found lost: this frame has no
  // weights, tier() is the tier of the next and reason() why. What the lost context held is given up, not
  // deleted. A tier that needs a context is passed over unless another one is current by then. kOutOfMemory
  // where there is none for the cpu tier: the next frame tries again.
  //
  // Where weights ease, the first frame on a new tier begins anew (FrameInput::reset).
  Status run(const FrameInput& input);

  Tier tier() const;
  const char* reason() const;  // one line; empty while the tier is the one of create()

  // Of the last frame: buffers of the GPU tiers, null on the cpu tier ...
  const Executor* executor() const;
  // ... and memory of the cpu tier, empty on the others. Valid until the next frame.
  std::span<const Float3> positions() const;
  std::span<const Float3> normals() const;   // empty without PlanOptions::normals
  std::span<const Float4> tangents() const;  // likewise
  std::span<const int16_t> weights() const;  // weightStride() a vertex

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::gl

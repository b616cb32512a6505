#pragma once

// Runs a frame plan on OpenGL 4.3 or newer. All calls need the same current context; the functions are found
// through epoxy.

#include <memory>
#include <span>

#include "furrow/frame_plan.h"

namespace furrow::gl {

// Whether the current context can run the gpu tier, and if not why (for the log and for the error of a forced
// tier).
struct Support {
  bool gpu = false;
  char reason[160] = {};  // "llvmpipe (LLVM 15), OpenGL 4.5" or what is missing
};
Support querySupport();

class Executor {
 public:
  Executor();
  ~Executor();

  // Compiles the shaders and makes and fills the buffers. `plan` and the asset it was made from must outlive
  // the executor.
  Status create(const FramePlan& plan);

  void upload(Buffer buffer, std::span<const std::byte> bytes);  // at most the buffer's size
  void run();                                                    // records every dispatch; does not wait
  void read(Buffer buffer, std::span<std::byte> bytes) const;    // waits
  uint32_t handle(Buffer buffer) const;                          // OpenGL name, 0 if unused

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::gl

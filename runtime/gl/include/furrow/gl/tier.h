#pragma once

// Which tier to run, chosen when a program starts.

#include <string_view>

#include "furrow/frame_plan.h"

namespace furrow::gl {

enum class Tier : uint8_t {
  kGpu = 0,    // compute, OpenGL 4.3
  kGpuRaster,  // the raster form, OpenGL 3.3
  kCpu,
};
const char* tierName(Tier tier);  // "gpu", "gpu-raster", "cpu"
Tier nextTier(Tier tier);         // where this one is no more; after kCpu, kCpu

// Which of them the current context can run, and if not why.
struct Support {
  bool gpu = false;
  bool gpu_raster = false;
  char reason[160] = {};  // "llvmpipe (LLVM 15), OpenGL 4.5" or what is missing
};
Support querySupport();

// What is asked for: `backend` is "gpu", "gpu-raster" or "cpu", or "auto" (or empty) for what the environment
// variable FURROW_BACKEND says, which takes the same words; where that is not set either, "auto". Fails with
// kInvalidArgument and the words for any other. `wanted` points at static text.
Status wantedTier(std::string_view backend, std::string_view& wanted);

struct TierChoice {
  Tier tier = Tier::kCpu;
  char reason[192] = {};  // one line for the log: why this tier and none before it
};

// The tier for `wanted`, from wantedTier(). "auto" takes the first that there is of gpu, gpu-raster and cpu.
// kUnavailable with the reason where a forced tier is missing: nothing takes its place. Asks the current
// context, unless `no_context` says why there is none. Keeps no state.
Status chooseTier(std::string_view wanted, std::string_view no_context, TierChoice& choice);

// The form of a frame plan for a GPU tier in the current context: kClustered for gpu where there are buffers
// and shared memory for it, else kStaged.
Form formOf(Tier tier);

}  // namespace furrow::gl

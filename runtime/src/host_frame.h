#pragma once

#include "host_instance.h"

namespace furrow {

// The numbers of a FurrowFrame, checked against the asset.
struct FrameValues {
  std::span<const float> morph_weights;  // empty: 0
  float scale = 1.0f;
  Response responses[kMaxLayers];
  float regions[kMaxLayers];  // with the drivers' answers
  Ease eases[kMaxLayers];
  uint32_t active_layers = 0;  // bit l
};
inline constexpr uint32_t kMostLaplaceSteps = 1000;
Status checkLaplace(const FurrowFrame& frame);
inline float laplaceRate(const FurrowFrame& frame) {
  return frame.laplace_rate == 0.0f ? 0.5f : frame.laplace_rate;
}

Status readValues(const AssetView& view, const FurrowFrame& frame, FrameValues& out);

Status runFrame(FurrowInstance& instance, const FurrowFrame& frame, FurrowFrameReport& report);
Status recapture(FurrowInstance& instance, const FurrowFrame& frame);

}  // namespace furrow

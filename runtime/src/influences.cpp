#include "furrow/skinning.h"

namespace furrow {

Status InfluencesJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "influences: no asset");
  if (keep == 0 || keep > asset->influences)
    return Status::error(StatusCode::kInvalidArgument, "influences: %u to keep, the asset has %u", keep,
                         asset->influences);
  const size_t least = size_t{asset->vertexCount()} * keep;
  if (joints.size() < least || weights.size() < least)
    return Status::error(StatusCode::kInvalidArgument, "influences: joints or weights are too short");
  return {};
}

void InfluencesJob::run(uint32_t begin, uint32_t end) const {
  constexpr uint16_t kTaken = 0xffff;
  for (uint32_t v = begin; v < end; ++v) {
    const uint16_t* joint = &asset->joints[size_t{v} * asset->influences];
    const uint16_t* weight = &asset->weights[size_t{v} * asset->influences];
    uint16_t* out_joint = &joints[size_t{v} * keep];
    uint16_t* out_weight = &weights[size_t{v} * keep];
    uint32_t sum = 0;
    for (uint32_t k = 0; k < keep; ++k) {
      // The strongest that comes after the one before, by falling weight and rising index.
      uint32_t best = kTaken;
      for (uint32_t i = 0; i < asset->influences; ++i) {
        const auto taken = [&] {
          for (uint32_t j = 0; j < k; ++j)
            if (out_weight[j] == i) return true;
          return false;
        };
        if ((best == kTaken || weight[i] > weight[best]) && !taken()) best = i;
      }
      out_weight[k] = static_cast<uint16_t>(best);
      sum += weight[best];
    }
    uint32_t left = 65535;
    for (uint32_t k = 0; k < keep; ++k) {
      const uint32_t from = out_weight[k];
      out_joint[k] = joint[from];
      out_weight[k] = static_cast<uint16_t>(uint32_t{weight[from]} * 65535u / sum);
      left -= out_weight[k];
    }
    out_weight[0] = static_cast<uint16_t>(out_weight[0] + left);  // at most keep - 1 steps
  }
}

}  // namespace furrow

#include <cmath>

#include "furrow/jobs.h"
#include "response_math.h"

namespace furrow {

float easeStep(float rate, float seconds) {
  return rate > 0.0f && std::isfinite(rate) ? 1.0f - std::exp(-rate * seconds) : 1.0f;
}

Status EaseJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "ease: no asset");
  const size_t count = size_t{asset->vertexCount()} * asset->weightStride();
  if (weights.size() < count || (!eases.empty() && state.size() < count))
    return Status::error(StatusCode::kInvalidArgument, "ease: weights or state are too short");
  if (!eases.empty() && eases.size() != asset->layerCount())
    return Status::error(StatusCode::kInvalidArgument, "ease: %zu eases, the asset has %u layers",
                         eases.size(), asset->layerCount());
  if (!(seconds >= 0.0f)) return Status::error(StatusCode::kInvalidArgument, "ease: negative time");
  if (!(fade >= 0.0f) || !(fade <= 1.0f))
    return Status::error(StatusCode::kInvalidArgument, "ease: the fade is not between 0 and 1");
  return {};
}

void EaseJob::run(uint32_t begin, uint32_t end) const {
  const size_t stride = asset->weightStride(), layers = asset->layerCount();
  float attack[kMaxLayers], release[kMaxLayers];
  for (size_t l = 0; l < layers; ++l) {
    attack[l] = reset || eases.empty() ? 1.0f : easeStep(eases[l].attack, seconds);
    release[l] = reset || eases.empty() ? 1.0f : easeStep(eases[l].release, seconds);
  }
  for (size_t v = begin; v < end; ++v)
    for (size_t l = 0; l < layers; ++l) {
      const size_t i = v * stride + l;
      float w = static_cast<float>(weights[i]) * (1.0f / 32767.0f);
      if (!eases.empty()) {
        const float s = state[i], step = std::abs(w) > std::abs(s) ? attack[l] : release[l];
        if (step != 1.0f) w = s + (w - s) * step;
        state[i] = w;
      }
      weights[i] = toSnorm16(clampUnit(w * fade));
    }
}

}  // namespace furrow

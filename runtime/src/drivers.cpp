#include "furrow/drivers.h"

#include <algorithm>

namespace furrow {

float drive(const Driver& driver, float weight) {
  const std::span<const Float2> curve = driver.curve;
  if (curve.empty()) return driver.gain * weight;
  const auto after = std::find_if(curve.begin(), curve.end(), [&](Float2 p) { return p.x > weight; });
  if (after == curve.begin()) return driver.gain * curve.front().y;
  if (after == curve.end()) return driver.gain * curve.back().y;
  const Float2 a = *(after - 1), b = *after;
  return driver.gain * (a.y + (b.y - a.y) * ((weight - a.x) / (b.x - a.x)));
}

void driveRegions(const AssetView& asset, std::span<const float> morph_weights,
                  std::span<const float> scripted, std::span<float> region_weights) {
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    float region = scripted.empty() ? 0.0f : scripted[l];
    for (uint32_t d = asset.layers[l].driver_begin; d < asset.layers[l].driver_end; ++d)
      region += drive(asset.drivers[d], morph_weights[asset.drivers[d].morph]);
    region_weights[l] = std::clamp(region, -1.0f, 1.0f);
  }
}

}  // namespace furrow

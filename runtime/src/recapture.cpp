#include "furrow/recapture.h"

#include <algorithm>
#include <cmath>

#include "rest_surface.h"

namespace furrow {

Status RecaptureJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "recapture: no asset");
  if (layer >= asset->layerCount())
    return Status::error(StatusCode::kInvalidArgument, "recapture: layer %u, the asset has %u", layer,
                         asset->layerCount());
  if (positions.size() < asset->vertexCount() ||
      coefficients.size() < size_t{asset->triangleCount()} * coefficientCount(asset->layers[layer].measure))
    return Status::error(StatusCode::kInvalidArgument, "recapture: positions or coefficients are too short");
  if (!(scale > 0.0f) || !std::isfinite(scale))
    return Status::error(StatusCode::kInvalidArgument, "recapture: scale is not positive");
  return {};
}

void RecaptureJob::run(uint32_t begin, uint32_t end) const {
  const Layer& from = asset->layers[layer];
  const size_t each = coefficientCount(from.measure);
  for (size_t t = begin; each > 0 && t < end; ++t) {
    const float* c = &from.coefficients[each * t];
    float* out = &coefficients[each * t];
    std::fill_n(out, each, 0.0f);
    if (std::all_of(c, c + each, [](float value) { return value == 0.0f; })) continue;
    Float3 p[3];
    for (size_t k = 0; k < 3; ++k) {
      p[k] = positions[asset->surface_indices[3 * t + k]];
      p[k] = {p[k].x / scale, p[k].y / scale, p[k].z / scale};
    }
    if (isNeedle(p[0], p[1], p[2])) continue;
    if (from.measure != Measure::kDirectional) {
      const uint32_t corners[] = {0, 1, 2};
      float numbers[3] = {};
      makeCoefficients({p, corners, corners}, from.measure, {}, 0, 1, numbers);
      std::copy_n(numbers, each, out);
      continue;
    }
    const auto along = [&](auto coordinate) {
      return double{c[0]} * (double{coordinate(p[1])} - coordinate(p[0])) +
             double{c[1]} * (double{coordinate(p[2])} - coordinate(p[0]));
    };
    const double x = along([](Float3 v) { return v.x; }), y = along([](Float3 v) { return v.y; }),
                 z = along([](Float3 v) { return v.z; });
    const double length = std::sqrt((x * x + y * y) + z * z);
    for (size_t k = 0; k < 2; ++k) out[k] = static_cast<float>(c[k] / length);
    if (!std::isfinite(out[0]) || !std::isfinite(out[1])) std::fill_n(out, each, 0.0f);
  }
}

}  // namespace furrow

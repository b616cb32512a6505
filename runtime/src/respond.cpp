#include <algorithm>
#include <bit>
#include <cmath>

#include "furrow/jobs.h"

namespace furrow {
namespace {

// Branch-free so that the loop over vertices vectorises; both within 4e-7 relative, and log2(1) is exactly 0.

inline float fastLog2(float x) {  // x > 0, normal
  const int32_t bits = std::bit_cast<int32_t>(x);
  const int32_t exponent = (bits - 0x3f3504f3) >> 23;  // mantissa in [sqrt(1/2), sqrt(2))
  const float mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float t = (mantissa - 1.0f) / (mantissa + 1.0f);
  const float t2 = t * t;
  const float series =
      t * (2.88539008f + t2 * (0.961796694f + t2 * (0.577078016f + t2 * (0.412198583f + t2 * 0.320598898f))));
  return static_cast<float>(exponent) + series;
}

inline float fastExp2(float y) {
  y = std::min(std::max(y, -126.0f), 126.0f);
  const float shifted = y + 12582912.0f;  // 1.5 * 2^23: rounds to the nearest integer
  const float whole = shifted - 12582912.0f;
  const float f = y - whole;
  const float series =
      1.0f + f * (0.693147181f +
                  f * (0.240226507f +
                       f * (0.0555041087f +
                            f * (0.00961812911f +
                                 f * (0.00133335581f + f * (0.000154035304f + f * 0.0000152527338f))))));
  const int32_t exponent = std::bit_cast<int32_t>(shifted) - 0x4b400000;
  return std::bit_cast<float>(std::bit_cast<int32_t>(series) + exponent * (1 << 23));
}

// I(alpha) = max(0, 1 - 2 / (1 + (alpha / lambda)^beta)) [Larsson, eq. 4].
inline float intensity(float log_alpha, float log_lambda, float beta) {
  return std::max(0.0f, 1.0f - 2.0f / (1.0f + fastExp2(beta * (log_alpha - log_lambda))));
}

inline float larsson(float q, float log_lambda, float beta, float log_stretch_lambda, float stretch_beta) {
  const float log_alpha = -fastLog2(q);
  return intensity(log_alpha, log_lambda, beta) - intensity(-log_alpha, log_stretch_lambda, stretch_beta);
}

inline float clampUnit(float w) {
  return std::min(std::max(w, -1.0f), 1.0f);
}

// SSE2 has no float-to-int16 rounding: adding 1.5 * 2^23 leaves the rounded value in the low bits.
inline int16_t toSnorm16(float w) {
  return static_cast<int16_t>(std::bit_cast<int32_t>(w * 32767.0f + 12582912.0f) - 0x4b400000);
}

// Blocks of vertices are gathered first, so that the arithmetic vectorises.
template <typename Weight>
void respondVertices(const RespondJob& job, uint32_t begin, uint32_t end, Weight weight) {
  constexpr uint32_t kBlock = 256;
  const uint32_t* vertex_point = job.asset->vertex_point.data();
  const std::span<const int16_t> bias = job.asset->layers[job.layer].bias;
  const size_t stride = job.asset->weightStride();
  float q[kBlock], offset[kBlock] = {};
  int16_t weights[kBlock];
  for (uint32_t first = begin; first < end; first += kBlock) {
    const uint32_t count = std::min(kBlock, end - first);
    for (uint32_t i = 0; i < count; ++i) q[i] = job.q[vertex_point[first + i]];
    for (uint32_t i = 0; !bias.empty() && i < count; ++i)
      offset[i] = static_cast<float>(bias[first + i]) * (1.0f / 32767.0f);
    for (uint32_t i = 0; i < count; ++i)
      weights[i] = toSnorm16(clampUnit((weight(std::max(q[i], kMinQ)) + offset[i]) + job.region));
    int16_t* out = job.weights.data() + first * stride + job.layer;
    for (uint32_t i = 0; i < count; ++i) out[i * stride] = weights[i];
  }
}

}  // namespace

Status RespondJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "respond: no asset");
  if (layer >= asset->layerCount())
    return Status::error(StatusCode::kInvalidArgument, "respond: layer %u, the asset has %u", layer,
                         asset->layerCount());
  if (q.size() < asset->pointCount() || weights.size() < size_t{asset->vertexCount()} * asset->weightStride())
    return Status::error(StatusCode::kInvalidArgument, "respond: q or weights are too short");
  const float positive[] = {response.lambda, response.beta, response.stretch_lambda, response.stretch_beta};
  for (float value : positive)
    if (!(value > 0.0f) || !std::isfinite(value))
      return Status::error(StatusCode::kInvalidArgument, "respond: lambda and beta must be positive");
  if (!std::isfinite(region))
    return Status::error(StatusCode::kInvalidArgument, "respond: the region weight is not finite");
  return {};
}

void RespondJob::run(uint32_t begin, uint32_t end) const {
  if (response.curve == Curve::kOat)
    return respondVertices(*this, begin, end, [](float value) { return 1.0f - value; });
  const float log_lambda = fastLog2(response.lambda);
  const float log_stretch_lambda = fastLog2(response.stretch_lambda);
  const float beta = response.beta;
  const float stretch_beta = response.stretch_beta;
  respondVertices(*this, begin, end, [=](float value) {
    return larsson(value, log_lambda, beta, log_stretch_lambda, stretch_beta);
  });
}

float respond(const Response& response, float q, float bias, float region) {
  q = std::max(q, kMinQ);
  const float weight = response.curve == Curve::kOat
                           ? 1.0f - q
                           : larsson(q, fastLog2(response.lambda), response.beta,
                                     fastLog2(response.stretch_lambda), response.stretch_beta);
  return clampUnit((weight + bias) + region);
}

}  // namespace furrow

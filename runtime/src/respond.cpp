#include <algorithm>
#include <cmath>

#include "response_math.h"

namespace furrow {
namespace {

// Blocks of vertices are gathered first, so that the arithmetic vectorises.
template <typename Function>
void respondVertices(const RespondJob& job, uint32_t begin, uint32_t end, const Function& curve) {
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
    respondBlock(curve, q, offset, job.region, count, weights);
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
  withCurve(response, [&](const auto& curve) { respondVertices(*this, begin, end, curve); });
}

float respond(const Response& response, float q, float bias, float region) {
  float weight = 0.0f;
  withCurve(response, [&](const auto& curve) { weight = curve(std::max(q, kMinQ)); });
  return clampUnit((weight + bias) + region);
}

}  // namespace furrow

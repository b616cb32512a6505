#include <algorithm>
#include <cmath>

#include "furrow/jobs.h"

namespace furrow {
namespace {

// The expression order of the measures is that of shaders/measure.glsl.

// The principal measure of a collapsed triangle is what rounding makes of 0, of either sign; NaN compares
// false.
inline float clampQ(float q) {
  return q >= 0.0f ? std::min(q, kMaxQ) : q < 0.0f ? 0.0f : 1.0f;
}

float directional(Float3 e1, Float3 e2, const float* c, float inverse_scale2) {
  const float x = c[0] * e1.x + c[1] * e2.x;
  const float y = c[0] * e1.y + c[1] * e2.y;
  const float z = c[0] * e1.z + c[1] * e2.z;
  return ((x * x + y * y) + z * z) * inverse_scale2;
}

float area(Float3 e1, Float3 e2, const float* c, float inverse_scale2) {
  const float x = e1.y * e2.z - e1.z * e2.y;
  const float y = e1.z * e2.x - e1.x * e2.z;
  const float z = e1.x * e2.y - e1.y * e2.x;
  return std::sqrt((x * x + y * y) + z * z) * c[0] * inverse_scale2;
}

float principal(Float3 e1, Float3 e2, const float* c, float inverse_scale2) {
  const Float3 f1 = {c[0] * e1.x, c[0] * e1.y, c[0] * e1.z};
  const Float3 f2 = {c[1] * e1.x + c[2] * e2.x, c[1] * e1.y + c[2] * e2.y, c[1] * e1.z + c[2] * e2.z};
  const float f11 = (f1.x * f1.x + f1.y * f1.y) + f1.z * f1.z;
  const float f22 = (f2.x * f2.x + f2.y * f2.y) + f2.z * f2.z;
  const float f12 = (f1.x * f2.x + f1.y * f2.y) + f1.z * f2.z;
  const float half = 0.5f * (f11 - f22);
  return (0.5f * (f11 + f22) - std::sqrt(half * half + f12 * f12)) * inverse_scale2;
}

// Edges of a block of triangles are gathered first, so that the arithmetic vectorises.
template <uint32_t kCoefficients, typename MeasureFunction>
void measureTriangles(const CompressJob& job, uint32_t begin, uint32_t end, MeasureFunction measure) {
  constexpr uint32_t kBlock = 128;
  const Float3* positions = job.positions.data();
  const uint32_t* corners = job.asset->surface_indices.data() + size_t{3} * begin;
  const float* coefficients =
      job.asset->layers[job.layer].coefficients.data() + size_t{kCoefficients} * begin;
  const float inverse_scale2 = 1.0f / (job.scale * job.scale);
  float edges[6][kBlock];
  for (uint32_t first = begin; first < end; first += kBlock) {
    const uint32_t count = std::min(kBlock, end - first);
    for (uint32_t i = 0; i < count; ++i, corners += 3) {
      const Float3 p0 = positions[corners[0]];
      const Float3 p1 = positions[corners[1]];
      const Float3 p2 = positions[corners[2]];
      edges[0][i] = p1.x - p0.x;
      edges[1][i] = p1.y - p0.y;
      edges[2][i] = p1.z - p0.z;
      edges[3][i] = p2.x - p0.x;
      edges[4][i] = p2.y - p0.y;
      edges[5][i] = p2.z - p0.z;
    }
    float* q = job.q.data() + first;
    for (uint32_t i = 0; i < count; ++i) {
      const float* c = coefficients + size_t{kCoefficients} * i;
      const float value = clampQ(measure(Float3{edges[0][i], edges[1][i], edges[2][i]},
                                         Float3{edges[3][i], edges[4][i], edges[5][i]}, c, inverse_scale2));
      float used = 0.0f;
      for (uint32_t k = 0; k < kCoefficients; ++k) used += std::abs(c[k]);
      q[i] = used == 0.0f ? -1.0f : value;
    }
    coefficients += size_t{kCoefficients} * count;
  }
}

}  // namespace

Status CompressJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "compress: no asset");
  if (layer >= asset->layerCount())
    return Status::error(StatusCode::kInvalidArgument, "compress: layer %u, the asset has %u", layer,
                         asset->layerCount());
  if (positions.size() < asset->vertexCount())
    return Status::error(StatusCode::kInvalidArgument, "compress: %zu positions, the asset has %u vertices",
                         positions.size(), asset->vertexCount());
  if (q.size() < asset->triangleCount())
    return Status::error(StatusCode::kInvalidArgument, "compress: q holds %zu triangles, the asset has %u",
                         q.size(), asset->triangleCount());
  if (!(scale > 0.0f) || !std::isfinite(scale))
    return Status::error(StatusCode::kInvalidArgument, "compress: scale is not positive");
  return {};
}

void CompressJob::run(uint32_t begin, uint32_t end) const {
  switch (asset->layers[layer].measure) {
    case Measure::kDirectional:
      return measureTriangles<2>(*this, begin, end, [](auto... a) { return directional(a...); });
    case Measure::kArea:
      return measureTriangles<1>(*this, begin, end, [](auto... a) { return area(a...); });
    case Measure::kPrincipal:
      return measureTriangles<3>(*this, begin, end, [](auto... a) { return principal(a...); });
    case Measure::kNone:
      std::fill(q.begin() + begin, q.begin() + end, 1.0f);
  }
}

}  // namespace furrow

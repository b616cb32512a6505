#include <algorithm>
#include <cmath>

#include "furrow/jobs.h"

namespace furrow {
namespace {

// The expression order of the measures is that of shaders/compress.comp.

float clampQ(float q) {
  return q >= 0.0f ? std::min(q, kMaxQ) : 1.0f;
}  // NaN compares false

Float3 edge(Float3 to, Float3 from) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
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

template <uint32_t kCoefficients, typename MeasureFunction>
void measureTriangles(const CompressJob& job, uint32_t begin, uint32_t end, MeasureFunction measure) {
  const Float3* positions = job.positions.data();
  const uint32_t* corners = job.asset->surface_indices.data();
  const float* coefficients = job.asset->layers[job.layer].coefficients.data();
  const float inverse_scale2 = 1.0f / (job.scale * job.scale);
  float* q = job.q.data();
  for (uint32_t t = begin; t < end; ++t) {
    const float* c = coefficients + size_t{kCoefficients} * t;
    const Float3 p0 = positions[corners[3 * size_t{t}]];
    const Float3 e1 = edge(positions[corners[3 * size_t{t} + 1]], p0);
    const Float3 e2 = edge(positions[corners[3 * size_t{t} + 2]], p0);
    const float value = clampQ(measure(e1, e2, c, inverse_scale2));
    bool in_no_ring = true;
    for (uint32_t i = 0; i < kCoefficients; ++i) in_no_ring &= c[i] == 0.0f;
    q[t] = in_no_ring ? -1.0f : value;
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
      return measureTriangles<2>(*this, begin, end, directional);
    case Measure::kArea:
      return measureTriangles<1>(*this, begin, end, area);
    case Measure::kPrincipal:
      return measureTriangles<3>(*this, begin, end, principal);
    case Measure::kNone:
      std::fill(q.begin() + begin, q.begin() + end, 1.0f);
  }
}

}  // namespace furrow

#include "furrow/jobs.h"

namespace furrow {

Status SmoothJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "smooth: no asset");
  if (triangle_q.size() < asset->triangleCount() || q.size() < asset->pointCount())
    return Status::error(StatusCode::kInvalidArgument,
                         "smooth: %zu triangles and %zu points, the asset has %u and %u", triangle_q.size(),
                         q.size(), asset->triangleCount(), asset->pointCount());
  return {};
}

void SmoothJob::run(uint32_t begin, uint32_t end) const {
  const uint32_t* offsets = asset->ring_offsets.data();
  const uint32_t* triangles = asset->ring_triangles.data();
  const uint16_t* weights = asset->ring_weights.data();
  for (uint32_t point = begin; point < end; ++point) {
    float sum = 0.0f;
    float total = 0.0f;
    for (uint32_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      const float value = triangle_q[triangles[i]];
      const float weight = value < 0.0f ? 0.0f : static_cast<float>(weights[i]);
      sum = sum + weight * value;
      total = total + weight;
    }
    q[point] = total > 0.0f ? sum / total : 1.0f;
  }
}

}  // namespace furrow

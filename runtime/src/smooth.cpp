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

Status LaplaceJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "laplace: no asset");
  if (triangle_q.size() < asset->triangleCount() || q.size() < asset->pointCount() ||
      out.size() < asset->pointCount())
    return Status::error(StatusCode::kInvalidArgument, "laplace: a span is too short");
  if (q.data() == out.data())
    return Status::error(StatusCode::kInvalidArgument, "laplace: q and out are the same");
  if (!(rate >= 0.0f) || !(rate <= 1.0f))
    return Status::error(StatusCode::kInvalidArgument, "laplace: the rate is not between 0 and 1");
  return {};
}

void LaplaceJob::run(uint32_t begin, uint32_t end) const {
  const uint32_t* vertex_point = asset->vertex_point.data();
  for (uint32_t point = begin; point < end; ++point) {
    float sum = 0.0f;
    float total = 0.0f;
    for (uint32_t i = asset->ring_offsets[point]; i < asset->ring_offsets[point + 1]; ++i) {
      const uint32_t triangle = asset->ring_triangles[i];
      if (triangle_q[triangle] < 0.0f) continue;
      const uint32_t* corner = &asset->surface_indices[3 * size_t{triangle}];
      const uint32_t p[3] = {vertex_point[corner[0]], vertex_point[corner[1]], vertex_point[corner[2]]};
      const int own = p[0] == point ? 0 : p[1] == point ? 1 : 2;
      const float weight = static_cast<float>(asset->ring_weights[i]);
      const float others = 0.5f * (q[p[(own + 1) % 3]] + q[p[(own + 2) % 3]]);
      sum = sum + weight * (q[point] + rate * (others - q[point]));
      total = total + weight;
    }
    out[point] = total > 0.0f ? sum / total : q[point];
  }
}

}  // namespace furrow

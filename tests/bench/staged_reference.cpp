#include "staged_reference.h"

#include <algorithm>
#include <bit>

namespace furrow::bench {
namespace {

float log2Of(float x) {
  const int32_t bits = std::bit_cast<int32_t>(x);
  const int32_t exponent = (bits - 0x3f3504f3) >> 23;
  const float mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float t = (mantissa - 1.0f) / (mantissa + 1.0f), t2 = t * t;
  return static_cast<float>(exponent) +
         t * (2.88539008f +
              t2 * (0.961796694f + t2 * (0.577078016f + t2 * (0.412198583f + t2 * 0.320598898f))));
}

float exp2Of(float y) {
  y = std::min(std::max(y, -126.0f), 126.0f);
  const float shifted = y + 12582912.0f, f = y - (shifted - 12582912.0f);
  const float series =
      1.0f + f * (0.693147181f +
                  f * (0.240226507f +
                       f * (0.0555041087f +
                            f * (0.00961812911f +
                                 f * (0.00133335581f + f * (0.000154035304f + f * 0.0000152527338f))))));
  return std::bit_cast<float>(std::bit_cast<int32_t>(series) +
                              (std::bit_cast<int32_t>(shifted) - 0x4b400000) * (1 << 23));
}

}  // namespace

StagedReference::StagedReference(const AssetView& asset)
    : rest_(asset.positions.begin(), asset.positions.end()),
      posed_(asset.vertexCount()),
      joints_(asset.joints.begin(), asset.joints.end()),
      joint_weights_(asset.weights.begin(), asset.weights.end()),
      corners_(asset.surface_indices.begin(), asset.surface_indices.end()),
      coefficients_(asset.layers[0].coefficients.begin(), asset.layers[0].coefficients.end()),
      triangle_q_(asset.triangleCount()),
      ring_offsets_(asset.ring_offsets.begin(), asset.ring_offsets.end()),
      ring_triangles_(asset.ring_triangles.begin(), asset.ring_triangles.end()),
      weights_(asset.pointCount()),
      beta_(asset.layers[0].response.beta) {
  for (uint16_t weight : asset.ring_weights)
    ring_weights_.push_back(static_cast<float>(weight) * (1.0f / 65535.0f));
}

void StagedReference::skin(const std::vector<Affine>& palette, uint32_t begin, uint32_t end) {
  for (uint32_t v = begin; v < end; ++v) {
    float m[12] = {};
    for (uint32_t k = 0; k < 4; ++k) {
      const float weight = static_cast<float>(joint_weights_[size_t{4} * v + k]) * (1.0f / 65535.0f);
      const float* joint = palette[joints_[size_t{4} * v + k]].m;
      for (int i = 0; i < 12; ++i) m[i] += weight * joint[i];
    }
    const Float3 p = rest_[v];
    posed_[v] = {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                 m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
}

void StagedReference::measure(uint32_t begin, uint32_t end) {
  for (uint32_t t = begin; t < end; ++t) {
    const uint32_t* corner = &corners_[size_t{3} * t];
    const Float3 a = posed_[corner[0]], b = posed_[corner[1]], c = posed_[corner[2]];
    const float c0 = coefficients_[size_t{2} * t], c1 = coefficients_[size_t{2} * t + 1];
    const float x = c0 * (b.x - a.x) + c1 * (c.x - a.x);
    const float y = c0 * (b.y - a.y) + c1 * (c.y - a.y);
    const float z = c0 * (b.z - a.z) + c1 * (c.z - a.z);
    triangle_q_[t] = std::min(x * x + y * y + z * z, 4.0f);
  }
}

void StagedReference::gather(uint32_t begin, uint32_t end) {
  constexpr uint32_t kBlock = 256;
  float q[kBlock];
  for (uint32_t first = begin; first < end; first += kBlock) {
    const uint32_t count = std::min(kBlock, end - first);
    for (uint32_t i = 0; i < count; ++i) {
      float sum = 0.0f;
      for (uint32_t k = ring_offsets_[first + i]; k < ring_offsets_[first + i + 1]; ++k)
        sum += ring_weights_[k] * triangle_q_[ring_triangles_[k]];
      q[i] = sum;
    }
    for (uint32_t i = 0; i < count; ++i) {
      const float log_alpha = -log2Of(std::max(q[i], 1.0f / 64.0f));
      const float strength = log_alpha >= 0.0f ? log_alpha : -log_alpha;
      const float rise = 1.0f - 2.0f / (1.0f + exp2Of(beta_ * strength));
      const float weight = log_alpha >= 0.0f ? rise : -rise;
      weights_[first + i] =
          static_cast<int16_t>(std::bit_cast<int32_t>(weight * 32767.0f + 12582912.0f) - 0x4b400000);
    }
  }
}

uint64_t StagedReference::bytes() const {
  const auto of = [](const auto&... arrays) {
    return (uint64_t{0} + ... + uint64_t{arrays.size() * sizeof arrays[0]});
  };
  return of(rest_, joints_, joint_weights_, posed_) + of(posed_, corners_, coefficients_, triangle_q_) +
         of(triangle_q_, ring_offsets_, ring_triangles_, ring_weights_, weights_);
}

}  // namespace furrow::bench

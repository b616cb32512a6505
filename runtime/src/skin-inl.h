// Linear blend skinning of kWidth vertices at a time. Compiled for every instruction set.

#if defined(FURROW_SKIN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FURROW_SKIN_INL_H
#undef FURROW_SKIN_INL_H
#else
#define FURROW_SKIN_INL_H
#endif

#include "furrow/types.h"
#include "src/deform_kernel.h"
#include "src/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {

constexpr float kUnorm16 = 1.0f / 65535.0f;
static_assert(65535.0f * kUnorm16 == 1.0f, "a single influence must not scale the vertex");

// A matrix a lane, entry by entry.
struct Matrices {
  Lanes m[3][4];
};

#if HWY_TARGET != HWY_SCALAR

// A matrix lies in this many vectors, its rows in their blocks.
constexpr uint32_t kMatrixVectors = (3 + kBlocks - 1) / kBlocks;

template <uint32_t kIndex>
HWY_INLINE Lanes matrixVector(const float* m) {
#if HWY_MAX_BYTES >= 64
  return hn::MaskedLoad(hn::FirstN(D(), 12), D(), m);
#else  // of two rows, the second vector has the last two
  return hn::LoadU(D(), m + 4 * kIndex);
#endif
}

// Block kRow of every group's vector.
template <uint32_t kRow>
HWY_INLINE Lanes gatherRow(const Lanes (&groups)[kBlocks][kMatrixVectors][4], int c) {
#if HWY_MAX_BYTES >= 64
  constexpr int kHalf = kRow < 2 ? 0x44 : 0xee, kOdd = kRow == 1 ? 0xdd : 0x88;
  const __m512 low = _mm512_shuffle_f32x4(groups[0][0][c].raw, groups[1][0][c].raw, kHalf);
  const __m512 high = _mm512_shuffle_f32x4(groups[2][0][c].raw, groups[3][0][c].raw, kHalf);
  return Lanes{_mm512_shuffle_f32x4(low, high, kOdd)};
#elif HWY_MAX_BYTES >= 32
  const Lanes low = groups[0][kRow / 2][c], high = groups[1][kRow / 2][c];
  return kRow == 0 ? hn::ConcatLowerLower(D(), high, low) : hn::ConcatUpperUpper(D(), high, low);
#else
  return groups[0][kRow][c];
#endif
}

// blend() of four vertices, whose columns c are then in the c-th vectors.
template <uint32_t kInfluences, typename Joint>
HWY_INLINE void blendFour(const Affine* palette, const Joint* joints, uint32_t influences,
                          const float* weights, size_t vertex_step, size_t influence_step,
                          Lanes (&out)[kMatrixVectors][4]) {
  for (uint32_t v = 0; v < 4; ++v) {
    Lanes sum[kMatrixVectors];
    for (Lanes& s : sum) s = hn::Zero(D());
    for (uint32_t k = 0; k < (kInfluences ? kInfluences : influences); ++k) {
      const Lanes w = all(weights[v * vertex_step + k * influence_step]);
      const float* m = palette[joints[v * influences + k]].m;
      sum[0] = sum[0] + w * matrixVector<0>(m);
      if constexpr (kMatrixVectors > 1) sum[1] = sum[1] + w * matrixVector<1>(m);
      if constexpr (kMatrixVectors > 2) sum[2] = sum[2] + w * matrixVector<2>(m);
    }
    for (uint32_t j = 0; j < kMatrixVectors; ++j) out[j][v] = sum[j];
  }
  for (auto& quad : out) transpose(quad[0], quad[1], quad[2], quad[3]);
}

#endif

// sum_k weight_k M_k, k ascending. Vertex v's k-th joint is joints[v * influences + k], its weight
// weights[v * vertex_step + k * influence_step]; a joint of weight 0 counts too, as 0 times its matrix.
template <uint32_t kInfluences, typename Joint>
HWY_INLINE Matrices blendFixed(const Affine* palette, const Joint* joints, uint32_t influences_or_0,
                               const float* weights, size_t vertex_step, size_t influence_step) {
  const uint32_t influences = kInfluences ? kInfluences : influences_or_0;
  Matrices out;
#if HWY_TARGET == HWY_SCALAR
  for (int v = 0; v < 4; ++v) {
    float sum[12] = {};
    for (uint32_t k = 0; k < influences; ++k) {
      const float w = weights[v * vertex_step + k * influence_step];
      const float* m = palette[joints[v * influences + k]].m;
      for (int i = 0; i < 12; ++i) sum[i] = sum[i] + w * m[i];
    }
    for (int i = 0; i < 12; ++i) out.m[i / 4][i % 4].v[v] = sum[i];
  }
#else
  Lanes groups[kBlocks][kMatrixVectors][4];
  const auto group = [&](uint32_t g) HWY_ATTR {
    blendFour<kInfluences>(palette, joints + 4 * g * influences, influences, weights + 4 * g * vertex_step,
                           vertex_step, influence_step, groups[g]);
  };
  group(0);  // not a loop, which would go through memory
  if constexpr (kBlocks > 1) group(1);
  if constexpr (kBlocks > 2) group(2), group(3);
  for (int c = 0; c < 4; ++c) {
    out.m[0][c] = gatherRow<0>(groups, c);
    out.m[1][c] = gatherRow<1>(groups, c);
    out.m[2][c] = gatherRow<2>(groups, c);
  }
#endif
  return out;
}

template <typename Joint>
HWY_INLINE Matrices blend(const Affine* palette, const Joint* joints, uint32_t influences,
                          const float* weights, size_t vertex_step, size_t influence_step) {
  return influences == 4 ? blendFixed<4>(palette, joints, influences, weights, vertex_step, influence_step)
                         : blendFixed<0>(palette, joints, influences, weights, vertex_step, influence_step);
}

// The expression order here is that of shaders/pose.glsl: both tiers must pose a vertex to the same bits.
HWY_INLINE void transformPoints(const Matrices& a, Lanes& x, Lanes& y, Lanes& z) {
  const Lanes p[3] = {x, y, z};
  const auto row = [&](const Lanes(&m)[4]) { return ((m[0] * p[0] + m[1] * p[1]) + m[2] * p[2]) + m[3]; };
  x = row(a.m[0]), y = row(a.m[1]), z = row(a.m[2]);
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#endif

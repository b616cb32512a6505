// The vectors of the cpu tier's kernels: four floats, or as many blocks of four as the instruction set has.
// Compiled for every one of them: to be included where hwy/foreach_target.h is.

#if defined(FURROW_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FURROW_LANES_INL_H
#undef FURROW_LANES_INL_H
#else
#define FURROW_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

constexpr uint32_t kBlocks = 1;
struct Lanes {
  float v[4];
};
template <typename Function>
HWY_INLINE Lanes each(Function f) {
  return {{f(0), f(1), f(2), f(3)}};
}
HWY_INLINE Lanes load(const float* p) {
  return {{p[0], p[1], p[2], p[3]}};
}
HWY_INLINE void store(Lanes a, float* p) {
  std::copy(a.v, a.v + 4, p);
}
HWY_INLINE Lanes all(float x) {
  return {{x, x, x, x}};
}
HWY_INLINE Lanes operator+(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] + b.v[i]; });
}
HWY_INLINE Lanes operator-(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] - b.v[i]; });
}
HWY_INLINE Lanes operator*(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] * b.v[i]; });
}
HWY_INLINE Lanes operator/(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] / b.v[i]; });
}
HWY_INLINE Lanes root(Lanes a) {
  return each([&](int i) { return std::sqrt(a.v[i]); });
}
HWY_INLINE Lanes atMost(Lanes a, float most) {
  return each([&](int i) { return std::min(a.v[i], most); });
}
// Where a > 0, `yes`, else `no`.
HWY_INLINE Lanes ifPositive(Lanes a, Lanes yes, Lanes no) {
  return each([&](int i) { return a.v[i] > 0.0f ? yes.v[i] : no.v[i]; });
}
// Where a < 0, `yes`, else `no`.
HWY_INLINE Lanes ifNegative(Lanes a, Lanes yes, Lanes no) {
  return each([&](int i) { return a.v[i] < 0.0f ? yes.v[i] : no.v[i]; });
}
// Where a >= 0, `yes`, else `no`.
HWY_INLINE Lanes ifNotNegative(Lanes a, Lanes yes, Lanes no) {
  return each([&](int i) { return a.v[i] >= 0.0f ? yes.v[i] : no.v[i]; });
}
HWY_INLINE bool allNotNegative(Lanes a) {
  return a.v[0] >= 0.0f && a.v[1] >= 0.0f && a.v[2] >= 0.0f && a.v[3] >= 0.0f;
}
HWY_INLINE bool allPositive(Lanes a) {
  return a.v[0] > 0.0f && a.v[1] > 0.0f && a.v[2] > 0.0f && a.v[3] > 0.0f;
}
HWY_INLINE void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes m[4] = {a, b, c, d};
  Lanes* out[4] = {&a, &b, &c, &d};
  for (int row = 0; row < 4; ++row)
    for (int k = 0; k < 4; ++k) out[row]->v[k] = m[k].v[row];
}
// Block i from at(i).
template <typename At>
HWY_INLINE Lanes loadBlocks(At at) {
  return load(at(0));
}
template <typename At>
HWY_INLINE Lanes gatherBlocks(At at) {
  return load(at(0));
}
// Block i to `p + i * step`.
HWY_INLINE void storeBlocks(Lanes a, float* p, size_t) {
  store(a, p);
}
HWY_INLINE Lanes fromUint16(const uint16_t* p) {
  return each([&](int i) { return static_cast<float>(p[i]); });
}
// `first` + each of them.
HWY_INLINE Lanes fromUint16(const uint16_t* p, int32_t first) {
  return each([&](int i) { return static_cast<float>(first + p[i]); });
}
// kWidth elements of three floats, and of four.
HWY_INLINE void load3(const float* p, Lanes& x, Lanes& y, Lanes& z) {
  x = each([&](int i) { return p[3 * i]; });
  y = each([&](int i) { return p[3 * i + 1]; });
  z = each([&](int i) { return p[3 * i + 2]; });
}
HWY_INLINE void store3(Lanes x, Lanes y, Lanes z, float* p) {
  for (int i = 0; i < 4; ++i) p[3 * i] = x.v[i], p[3 * i + 1] = y.v[i], p[3 * i + 2] = z.v[i];
}
HWY_INLINE void load4(const float* p, Lanes& x, Lanes& y, Lanes& z, Lanes& w) {
  x = load(p), y = load(p + 4), z = load(p + 8), w = load(p + 12);
  transpose(x, y, z, w);
}
HWY_INLINE void store4(Lanes x, Lanes y, Lanes z, Lanes w, float* p) {
  transpose(x, y, z, w);
  store(x, p), store(y, p + 4), store(z, p + 8), store(w, p + 12);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using D4 = hn::FixedTag<float, 4>;
constexpr uint32_t kBlocks = HWY_MAX_BYTES >= 64 ? 4 : HWY_MAX_BYTES >= 32 ? 2 : 1;
using Lanes = hn::Vec<D>;
using Block = hn::Vec<D4>;
HWY_INLINE Lanes load(const float* p) {
  return hn::LoadU(D(), p);
}
HWY_INLINE void store(Lanes a, float* p) {
  hn::StoreU(a, D(), p);
}
HWY_INLINE Lanes all(float x) {
  return hn::Set(D(), x);
}
HWY_INLINE Lanes root(Lanes a) {
  return hn::Sqrt(a);
}
HWY_INLINE Lanes atMost(Lanes a, float most) {
  return hn::Min(a, all(most));
}
HWY_INLINE Lanes ifPositive(Lanes a, Lanes yes, Lanes no) {
  return hn::IfThenElse(a > hn::Zero(D()), yes, no);
}
HWY_INLINE Lanes ifNegative(Lanes a, Lanes yes, Lanes no) {
  return hn::IfThenElse(a < hn::Zero(D()), yes, no);
}
HWY_INLINE Lanes ifNotNegative(Lanes a, Lanes yes, Lanes no) {
  return hn::IfThenElse(a >= hn::Zero(D()), yes, no);
}
HWY_INLINE bool allNotNegative(Lanes a) {
  return hn::AllTrue(D(), a >= hn::Zero(D()));
}
HWY_INLINE bool allPositive(Lanes a) {
  return hn::AllTrue(D(), a > hn::Zero(D()));
}
// In each block.
HWY_INLINE void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& e) {
  const D d;
  const Lanes ac0 = hn::InterleaveLower(d, a, c), ac1 = hn::InterleaveUpper(d, a, c);
  const Lanes be0 = hn::InterleaveLower(d, b, e), be1 = hn::InterleaveUpper(d, b, e);
  a = hn::InterleaveLower(d, ac0, be0);
  b = hn::InterleaveUpper(d, ac0, be0);
  c = hn::InterleaveLower(d, ac1, be1);
  e = hn::InterleaveUpper(d, ac1, be1);
}
HWY_INLINE void storeBlocks(Lanes a, float* p, size_t step) {
#if HWY_MAX_BYTES >= 64
  _mm_storeu_ps(p, _mm512_castps512_ps128(a.raw));
  _mm_storeu_ps(p + step, _mm512_extractf32x4_ps(a.raw, 1));
  _mm_storeu_ps(p + 2 * step, _mm512_extractf32x4_ps(a.raw, 2));
  _mm_storeu_ps(p + 3 * step, _mm512_extractf32x4_ps(a.raw, 3));
#elif HWY_MAX_BYTES >= 32
  hn::StoreU(hn::LowerHalf(D4(), a), D4(), p);
  hn::StoreU(hn::UpperHalf(D4(), a), D4(), p + step);
#else
  (void)step;
  store(a, p);
#endif
}
// Block i of all kBlocks vectors side by side at `p + i * step`.
HWY_INLINE void storeColumns(const Lanes* a, float* p, size_t step) {
#if HWY_MAX_BYTES >= 64
  const __m512 low01 = _mm512_shuffle_f32x4(a[0].raw, a[1].raw, 0x44),
               high01 = _mm512_shuffle_f32x4(a[0].raw, a[1].raw, 0xee),
               low23 = _mm512_shuffle_f32x4(a[2].raw, a[3].raw, 0x44),
               high23 = _mm512_shuffle_f32x4(a[2].raw, a[3].raw, 0xee);
  _mm512_storeu_ps(p, _mm512_shuffle_f32x4(low01, low23, 0x88));
  _mm512_storeu_ps(p + step, _mm512_shuffle_f32x4(low01, low23, 0xdd));
  _mm512_storeu_ps(p + 2 * step, _mm512_shuffle_f32x4(high01, high23, 0x88));
  _mm512_storeu_ps(p + 3 * step, _mm512_shuffle_f32x4(high01, high23, 0xdd));
#elif HWY_MAX_BYTES >= 32
  store(hn::ConcatLowerLower(D(), a[1], a[0]), p);
  store(hn::ConcatUpperUpper(D(), a[1], a[0]), p + step);
#else
  (void)step;
  store(a[0], p);
#endif
}
HWY_INLINE Lanes fromUint16(const uint16_t* p) {
  const hn::Rebind<uint16_t, D> d16;
  const hn::Rebind<int32_t, D> d32;
  return hn::ConvertTo(D(), hn::PromoteTo(d32, hn::LoadU(d16, p)));
}
HWY_INLINE Lanes fromUint16(const uint16_t* p, int32_t first) {
  const hn::Rebind<uint16_t, D> d16;
  const hn::Rebind<int32_t, D> d32;
  return hn::ConvertTo(D(), hn::Set(d32, first) + hn::PromoteTo(d32, hn::LoadU(d16, p)));
}
// Block i from at(i). Not by masked loads: the hardware does not prefetch after those.
template <typename At>
HWY_INLINE Lanes loadBlocks(At at) {
  const auto block = [&](int i) HWY_ATTR { return hn::LoadU(D4(), at(i)); };
#if HWY_MAX_BYTES >= 64
  const hn::Half<D> half;
  return hn::Combine(D(), hn::Combine(half, block(3), block(2)), hn::Combine(half, block(1), block(0)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(D(), block(1), block(0));
#else
  return block(0);
#endif
}
// The same from memory in the first cache, where the hardware need not prefetch.
template <typename At>
HWY_INLINE Lanes gatherBlocks(At at) {
#if HWY_MAX_BYTES >= 64  // loads that blend leave the shuffles their ports
  __m512 blocks = _mm512_castps128_ps512(_mm_loadu_ps(at(0)));
  blocks = _mm512_mask_broadcast_f32x4(blocks, 0x00f0, _mm_loadu_ps(at(1)));
  blocks = _mm512_mask_broadcast_f32x4(blocks, 0x0f00, _mm_loadu_ps(at(2)));
  return Lanes{_mm512_mask_broadcast_f32x4(blocks, 0xf000, _mm_loadu_ps(at(3)))};
#else
  return loadBlocks(at);
#endif
}
HWY_INLINE Lanes loadBlocks(const float* p, size_t step) {
  return loadBlocks([&](int i) HWY_ATTR { return p + i * step; });
}
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128
// In each block: a[kA], a[kB], b[kC], b[kD].
template <int kA, int kB, int kC, int kD>
HWY_INLINE Lanes shuffle(Lanes a, Lanes b) {
  constexpr int kOrder = kA | kB << 2 | kC << 4 | kD << 6;
#if HWY_MAX_BYTES >= 64
  return Lanes{_mm512_shuffle_ps(a.raw, b.raw, kOrder)};
#elif HWY_MAX_BYTES >= 32
  return Lanes{_mm256_shuffle_ps(a.raw, b.raw, kOrder)};
#else
  return Lanes{_mm_shuffle_ps(a.raw, b.raw, kOrder)};
#endif
}
HWY_INLINE void load3(const float* p, Lanes& x, Lanes& y, Lanes& z) {
  const Lanes a = loadBlocks(p, 12), b = loadBlocks(p + 4, 12), c = loadBlocks(p + 8, 12);
  const Lanes yz01 = shuffle<1, 2, 0, 1>(a, b), xy23 = shuffle<2, 3, 1, 2>(b, c);
  x = shuffle<0, 3, 0, 2>(a, xy23);
  y = shuffle<0, 2, 1, 3>(yz01, xy23);
  z = shuffle<1, 3, 0, 3>(yz01, c);
}
HWY_INLINE void store3(Lanes x, Lanes y, Lanes z, float* p) {
  const Lanes x02y02 = shuffle<0, 2, 0, 2>(x, y), y13z13 = shuffle<1, 3, 1, 3>(y, z),
              z02x13 = shuffle<0, 2, 1, 3>(z, x);
  storeBlocks(shuffle<0, 2, 0, 2>(x02y02, z02x13), p, 12);
  storeBlocks(shuffle<0, 2, 1, 3>(y13z13, x02y02), p + 4, 12);
  storeBlocks(shuffle<1, 3, 1, 3>(z02x13, y13z13), p + 8, 12);
}
#else
HWY_INLINE void load3(const float* p, Lanes& x, Lanes& y, Lanes& z) {
  hn::LoadInterleaved3(D(), p, x, y, z);
}
HWY_INLINE void store3(Lanes x, Lanes y, Lanes z, float* p) {
  hn::StoreInterleaved3(x, y, z, D(), p);
}
#endif
HWY_INLINE void load4(const float* p, Lanes& x, Lanes& y, Lanes& z, Lanes& w) {
  x = loadBlocks(p, 16), y = loadBlocks(p + 4, 16), z = loadBlocks(p + 8, 16), w = loadBlocks(p + 12, 16);
  transpose(x, y, z, w);
}
HWY_INLINE void store4(Lanes x, Lanes y, Lanes z, Lanes w, float* p) {
  transpose(x, y, z, w);
  storeBlocks(x, p, 16), storeBlocks(y, p + 4, 16), storeBlocks(z, p + 8, 16), storeBlocks(w, p + 12, 16);
}

#endif

constexpr uint32_t kWidth = 4 * kBlocks;

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#endif

// Responses of kWidth vertices at a time: the arithmetic of response_math.h, to the same bits. Compiled for
// every instruction set.

#if defined(FURROW_RESPOND_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FURROW_RESPOND_INL_H
#undef FURROW_RESPOND_INL_H
#else
#define FURROW_RESPOND_INL_H
#endif

#include "src/lanes-inl.h"
#include "src/response_math.h"

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

template <bool kSecond, typename Curve>
HWY_INLINE void respondVertices(const Curve& curve, const float* q, const float* bias, float region,
                                uint32_t count, uint32_t* pairs) {
  for (uint32_t i = 0; i < count; ++i) {
    const int16_t w = toSnorm16(clampUnit((curve(std::max(q[i], kMinQ)) + bias[i]) + region));
    const uint32_t bits = static_cast<uint16_t>(w);
    pairs[i] = kSecond ? pairs[i] | bits << 16 : bits;
  }
}

#else

using DInt = hn::RebindToSigned<D>;

HWY_INLINE Lanes log2(Lanes x) {
  const DInt d;
  const auto bits = hn::BitCast(d, x);
  const auto exponent = hn::ShiftRight<23>(bits - hn::Set(d, 0x3f3504f3));
  const Lanes mantissa = hn::BitCast(D(), bits - hn::ShiftLeft<23>(exponent));
  const Lanes t = (mantissa - all(1.0f)) / (mantissa + all(1.0f));
  const Lanes t2 = t * t;
  const Lanes series =
      t * (all(kLog2Series[0]) +
           t2 * (all(kLog2Series[1]) +
                 t2 * (all(kLog2Series[2]) + t2 * (all(kLog2Series[3]) + t2 * all(kLog2Series[4])))));
  return hn::ConvertTo(D(), exponent) + series;
}

HWY_INLINE Lanes exp2(Lanes y) {
  const DInt d;
  y = hn::Min(hn::Max(y, all(-126.0f)), all(126.0f));
  const Lanes shifted = y + all(kRounder);
  const Lanes f = y - (shifted - all(kRounder));
  Lanes series = all(kExp2Series[6]) + f * all(kExp2Series[7]);
  for (int i = 5; i >= 0; --i) series = all(kExp2Series[i]) + f * series;
  const auto exponent = hn::BitCast(d, shifted) - hn::Set(d, kRounderBits);
  return hn::BitCast(D(), hn::BitCast(d, series) + hn::ShiftLeft<23>(exponent));
}

HWY_INLINE Lanes intensity(Lanes log_alpha, Lanes log_lambda, Lanes beta) {
  return hn::Max(hn::Zero(D()), all(1.0f) - all(2.0f) / (all(1.0f) + exp2(beta * (log_alpha - log_lambda))));
}

HWY_INLINE Lanes answer(const OatCurve&, Lanes q) {
  return all(1.0f) - q;
}
HWY_INLINE Lanes answer(const LarssonCurve& c, Lanes q) {
  const Lanes log_alpha = hn::Neg(log2(q));
  return intensity(log_alpha, all(c.log_lambda), all(c.beta)) -
         intensity(hn::Neg(log_alpha), all(c.log_stretch_lambda), all(c.stretch_beta));
}
HWY_INLINE Lanes answer(const OneSidedLarssonCurve& c, Lanes q) {
  const Lanes log_alpha = hn::Neg(log2(q));
  const auto squeezed = log_alpha >= hn::Zero(D());
  const Lanes weight =
      intensity(hn::Abs(log_alpha), hn::IfThenElse(squeezed, all(c.log_lambda), all(c.log_stretch_lambda)),
                hn::IfThenElse(squeezed, all(c.beta), all(c.stretch_beta)));
  return hn::IfThenElse(squeezed, weight, hn::Neg(weight));
}

template <bool kSecond, typename Curve>
HWY_INLINE void respondVertices(const Curve& curve, const float* q, const float* bias, float region,
                                uint32_t count, uint32_t* pairs) {
  const DInt d;
  auto* out = reinterpret_cast<int32_t*>(pairs);
  for (uint32_t i = 0; i < count; i += kWidth) {
    const Lanes w = (answer(curve, hn::Max(load(q + i), all(kMinQ))) + load(bias + i)) + all(region);
    const Lanes clamped = hn::Min(hn::Max(w, all(-1.0f)), all(1.0f));
    const auto bits = hn::BitCast(d, clamped * all(32767.0f) + all(kRounder)) - hn::Set(d, kRounderBits);
    if constexpr (kSecond)
      hn::StoreU(hn::LoadU(d, out + i) | hn::ShiftLeft<16>(bits), d, out + i);
    else
      hn::StoreU(bits & hn::Set(d, 0xffff), d, out + i);
  }
}

#endif

// Weights as snorm16 from q and bias, into the lower halves of `pairs`, whose upper halves become 0, or into
// the upper ones. Arrays are padded to whole vectors.
HWY_INLINE void respondPairs(const Response& response, const float* q, const float* bias, float region,
                             uint32_t count, bool upper, uint32_t* pairs) {
  withCurve(response, [&](const auto& curve) HWY_ATTR {
    if (upper)
      respondVertices<true>(curve, q, bias, region, count, pairs);
    else
      respondVertices<false>(curve, q, bias, region, count, pairs);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#endif

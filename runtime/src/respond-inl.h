// Responses of many vertices at a time: the arithmetic of response_math.h, to the same bits. Compiled for
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

// Vectors in step with one another: a response is one long chain of operations, of which a core must have
// several at work.
constexpr uint32_t kTeam = 8;
struct Team {
  Lanes v[kTeam];
};
template <typename Function>
HWY_INLINE Team teamOf(Function f) {
  Team out;
  for (uint32_t i = 0; i < kTeam; ++i) out.v[i] = f(i);
  return out;
}
HWY_INLINE Team operator+(const Team& a, const Team& b) {
  return teamOf([&](uint32_t i) HWY_ATTR { return a.v[i] + b.v[i]; });
}
HWY_INLINE Team operator-(const Team& a, const Team& b) {
  return teamOf([&](uint32_t i) HWY_ATTR { return a.v[i] - b.v[i]; });
}
HWY_INLINE Team operator*(const Team& a, const Team& b) {
  return teamOf([&](uint32_t i) HWY_ATTR { return a.v[i] * b.v[i]; });
}
HWY_INLINE Team operator/(const Team& a, const Team& b) {
  return teamOf([&](uint32_t i) HWY_ATTR { return a.v[i] / b.v[i]; });
}
HWY_INLINE Team operator-(const Team& a) {
  return teamOf([&](uint32_t i) HWY_ATTR { return hn::Neg(a.v[i]); });
}
HWY_INLINE Team teamOf(float x) {
  return teamOf([&](uint32_t) HWY_ATTR { return all(x); });
}
HWY_INLINE Team clamped(const Team& a, float low, float high) {
  return teamOf([&](uint32_t i) HWY_ATTR { return hn::Min(hn::Max(a.v[i], all(low)), all(high)); });
}
HWY_INLINE Team magnitude(const Team& a) {
  return teamOf([&](uint32_t i) HWY_ATTR { return hn::Abs(a.v[i]); });
}
// `yes` where x has no sign, else `no`.
HWY_INLINE Team select(const Team& x, const Team& yes, const Team& no) {
  return teamOf([&](uint32_t i) HWY_ATTR { return hn::IfNegativeThenElse(x.v[i], no.v[i], yes.v[i]); });
}
// a >= 0 with the sign of b.
HWY_INLINE Team signedAs(const Team& a, const Team& b) {
  return teamOf([&](uint32_t i) HWY_ATTR { return hn::CopySignToAbs(a.v[i], b.v[i]); });
}

using DInt = hn::RebindToSigned<D>;

HWY_INLINE Team log2(const Team& x) {
  const DInt d;
  Team exponent, mantissa;
  for (uint32_t i = 0; i < kTeam; ++i) {
    const auto bits = hn::BitCast(d, x.v[i]);
    const auto whole = hn::ShiftRight<23>(bits - hn::Set(d, 0x3f3504f3));
    exponent.v[i] = hn::ConvertTo(D(), whole);
    mantissa.v[i] = hn::BitCast(D(), bits - hn::ShiftLeft<23>(whole));
  }
  const Team t = (mantissa - teamOf(1.0f)) / (mantissa + teamOf(1.0f));
  const Team t2 = t * t;
  Team series = teamOf(kLog2Series[2]);
  for (int i = 1; i >= 0; --i) series = teamOf(kLog2Series[i]) + t2 * series;
  return exponent + t * series;
}

// kRounderBits need not be taken from what is shifted out.
HWY_INLINE Team exp2(const Team& x) {
  const DInt d;
  const Team y = clamped(x, 0.0f, 126.0f);
  const Team shifted = y + teamOf(kRounder);
  const Team f = y - (shifted - teamOf(kRounder));
  Team series = teamOf(kExp2Series[5]);
  for (int i = 4; i >= 0; --i) series = teamOf(kExp2Series[i]) + f * series;
  return teamOf([&](uint32_t i) HWY_ATTR {
    const auto exponent = hn::ShiftLeft<23>(hn::BitCast(d, shifted.v[i]));
    return hn::BitCast(D(), hn::BitCast(d, series.v[i]) + exponent);
  });
}

HWY_INLINE Team intensity(const Team& log_alpha, const Team& log_lambda, const Team& beta) {
  return teamOf(1.0f) - teamOf(2.0f) / (teamOf(1.0f) + exp2(beta * (log_alpha - log_lambda)));
}

HWY_INLINE Team answer(const OatCurve&, const Team& q) {
  return teamOf(1.0f) - q;
}
HWY_INLINE Team answer(const LarssonCurve& c, const Team& q) {
  const Team log_alpha = -log2(q);
  return intensity(log_alpha, teamOf(c.log_lambda), teamOf(c.beta)) -
         intensity(-log_alpha, teamOf(c.log_stretch_lambda), teamOf(c.stretch_beta));
}
HWY_INLINE Team answer(const OneSidedLarssonCurve& c, const Team& q) {
  const Team log_alpha = -log2(q);
  const Team weight =
      intensity(magnitude(log_alpha), select(log_alpha, teamOf(c.log_lambda), teamOf(c.log_stretch_lambda)),
                select(log_alpha, teamOf(c.beta), teamOf(c.stretch_beta)));
  return signedAs(weight, log_alpha);
}

template <bool kSecond, typename Curve>
HWY_INLINE void respondVertices(const Curve& curve, const float* q, const float* bias, float region,
                                uint32_t count, uint32_t* pairs) {
  const DInt d;
  for (uint32_t first = 0; first < count; first += kTeam * kWidth) {
    const Team each =
        teamOf([&](uint32_t i) HWY_ATTR { return hn::Max(load(q + first + i * kWidth), all(kMinQ)); });
    const Team biases = teamOf([&](uint32_t i) HWY_ATTR { return load(bias + first + i * kWidth); });
    const Team w = clamped((answer(curve, each) + biases) + teamOf(region), -1.0f, 1.0f);
    const Team rounded = w * teamOf(32767.0f) + teamOf(kRounder);
    auto* out = reinterpret_cast<int32_t*>(pairs) + first;
    for (uint32_t i = 0; i < kTeam; ++i, out += kWidth) {
      const auto bits = hn::BitCast(d, rounded.v[i]);  // of which kRounderBits leave the lower half alone
      if constexpr (kSecond)
        hn::StoreU(hn::LoadU(d, out) | hn::ShiftLeft<16>(bits), d, out);
      else
        hn::StoreU(bits & hn::Set(d, 0xffff), d, out);
    }
  }
}

#endif

// Weights as snorm16 from q and bias, into the lower halves of `pairs`, whose upper halves become 0, or into
// the upper ones. Arrays are padded to kVertexPad.
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

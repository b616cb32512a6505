#pragma once

// The arithmetic of a response, shared by the staged and the clustered frame so that both give the same bits.
// Branch-free so that loops over it vectorise.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "furrow/jobs.h"

namespace furrow {

// Adding 1.5 * 2^23 rounds to the nearest integer and leaves it in the low bits.
inline constexpr float kRounder = 12582912.0f;
inline constexpr int32_t kRounderBits = 0x4b400000;

// Least in the largest relative error.
inline constexpr float kLog2Series[] = {2.88539042f, 0.961588264f, 0.595783951f};
inline constexpr float kExp2Series[] = {1.0f,          0.693146978f,   0.240222421f,
                                        0.0555073374f, 0.00967151261f, 0.00132647284f};

// Within 4e-7 relative, and fastLog2(1) is exactly 0. x > 0, normal.
inline float fastLog2(float x) {
  const int32_t bits = std::bit_cast<int32_t>(x);
  const int32_t exponent = (bits - 0x3f3504f3) >> 23;  // mantissa in [sqrt(1/2), sqrt(2))
  const float mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float t = (mantissa - 1.0f) / (mantissa + 1.0f);
  const float t2 = t * t;
  const float series = t * (kLog2Series[0] + t2 * (kLog2Series[1] + t2 * kLog2Series[2]));
  return static_cast<float>(exponent) + series;
}

// Within 4e-7 relative, and fastExp2(0) is exactly 1; y is clamped to [0, 126].
inline float fastExp2(float y) {
  y = std::min(std::max(y, 0.0f), 126.0f);
  const float shifted = y + kRounder;
  const float whole = shifted - kRounder;
  const float f = y - whole;
  float series = kExp2Series[5];
  for (int i = 4; i >= 0; --i) series = kExp2Series[i] + f * series;
  const int32_t exponent = std::bit_cast<int32_t>(shifted) - kRounderBits;
  return std::bit_cast<float>(std::bit_cast<int32_t>(series) + exponent * (1 << 23));
}

// I(alpha) = max(0, 1 - 2 / (1 + (alpha / lambda)^beta)) [Larsson, eq. 4].
inline float intensity(float log_alpha, float log_lambda, float beta) {
  return 1.0f - 2.0f / (1.0f + fastExp2(beta * (log_alpha - log_lambda)));
}

inline float clampUnit(float w) {
  return std::min(std::max(w, -1.0f), 1.0f);
}

// SSE2 has no float-to-int16 rounding.
inline int16_t toSnorm16(float w) {
  return static_cast<int16_t>(std::bit_cast<int32_t>(w * 32767.0f + kRounder) - kRounderBits);
}

// Responses made ready for many q >= kMinQ.

struct OatCurve {
  float operator()(float q) const { return 1.0f - q; }
};

struct LarssonCurve {
  explicit LarssonCurve(const Response& r)
      : log_lambda(fastLog2(r.lambda)),
        beta(r.beta),
        log_stretch_lambda(fastLog2(r.stretch_lambda)),
        stretch_beta(r.stretch_beta) {}
  float operator()(float q) const {
    const float log_alpha = -fastLog2(q);
    return intensity(log_alpha, log_lambda, beta) - intensity(-log_alpha, log_stretch_lambda, stretch_beta);
  }
  float log_lambda, beta, log_stretch_lambda, stretch_beta;
};

// The same bits at half the cost where no q answers to both lambdas, which then are at least 1.
struct OneSidedLarssonCurve : LarssonCurve {
  using LarssonCurve::LarssonCurve;
  float operator()(float q) const {
    const float log_alpha = -fastLog2(q);
    const bool squeezed = log_alpha >= 0.0f;
    const float weight = intensity(std::abs(log_alpha), squeezed ? log_lambda : log_stretch_lambda,
                                   squeezed ? beta : stretch_beta);
    return squeezed ? weight : -weight;
  }
};

// Calls `use` with the curve that computes the response.
template <typename Use>
inline void withCurve(const Response& response, Use use) {
  if (response.curve == Curve::kOat)
    use(OatCurve());
  else if (response.lambda >= 1.0f && response.stretch_lambda >= 1.0f)
    use(OneSidedLarssonCurve(response));
  else
    use(LarssonCurve(response));
}

// The weights of `count` vertices from their q and bias.
template <typename Function>
inline void respondBlock(const Function& curve, const float* q, const float* bias, float region,
                         uint32_t count, int16_t* weights) {
  for (uint32_t i = 0; i < count; ++i)
    weights[i] = toSnorm16(clampUnit((curve(std::max(q[i], kMinQ)) + bias[i]) + region));
}

}  // namespace furrow

#include "pipeline/maps/synthesis.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <thread>

#include "pipeline/maps/kernels.h"
#include "pipeline/maps/texel_map.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr float kTwoPi = 6.28318531f;
constexpr float kSteepest = 1.2f;       // slope; the runtime's fast normalisation is good up to 1.22
constexpr float kDarkest = 0.5f;        // W of the deepest valley
constexpr float kMinorDepth = 0.22f;    // of a full minor crease, of the whole depth
constexpr float kBroken = 0.25f, kWhole = 0.7f;  // coherence of the waves where lines end, and from which they are at full depth

Irregularity irregularityOf(Preset preset) {
  if (preset == Preset::kSkin) {
    return {.sway = 0.45, .sway_length = 5.0, .ridge_steps = 24, .shallowest = 0.12, .ending = 0.12, .minor_creases = 0.45};
  }
  return {.sway = 0.6, .sway_length = 4.0, .ridge_steps = 12, .shallowest = 0.1, .ending = 0.15, .minor_creases = 0.0};
}

// A value over the surface and its gradient.
struct Varying {
  float value = 0.0f;
  glm::vec3 gradient{0.0f};
};

Varying operator*(const Varying& a, const Varying& b) {
  return {a.value * b.value, a.gradient * b.value + b.gradient * a.value};
}

Varying quotient(const Varying& a, const Varying& b) {
  const float ratio = a.value / b.value;
  return {ratio, (a.gradient - b.gradient * ratio) / b.value};
}

Varying smoothStep(float low, float high, const Varying& v) {
  const float t = std::clamp((v.value - low) / (high - low), 0.0f, 1.0f);
  return {t * t * (3.0f - 2.0f * t), v.gradient * (6.0f * t * (1.0f - t) / (high - low))};
}

// Height over one period of the phase, mean 0, ridge to valley 1; even, since the phase of a line field has no sign.
struct Profile {
  float value = 0.0f, slope = 0.0f;  // d value / d phase
};

// Mean of (1/2 - 1/2 cos)^n over a period: the central binomial coefficient over 4^n.
constexpr float kMean1 = 0.5f, kMean2 = 0.375f, kMean3 = 0.3125f, kMean6 = 0.2255859375f;

Profile skin(float cos, float sin) {
  const float t = 0.5f - 0.5f * cos, t2 = t * t, t5 = t2 * t2 * t;
  const float valley = 0.35f * t2 + 0.65f * t5 * t;
  return {0.35f * kMean2 + 0.65f * kMean6 - valley, -(0.7f * t + 3.9f * t5) * 0.5f * sin};
}

Profile cloth(float cos, float sin) {
  const float t = 0.5f + 0.5f * cos;
  return {0.55f * (t - kMean1) + 0.45f * (t * t - kMean2), -(0.55f + 0.9f * t) * 0.5f * sin};
}

constexpr float deepest(Preset preset) {
  return preset == Preset::kSkin ? 1.0f - 0.35f * kMean2 - 0.65f * kMean6 : 0.55f * kMean1 + 0.45f * kMean2;
}

// A small crease on the ridge.
Profile minorCrease(float cos, float sin) {
  const float t = 0.5f + 0.5f * cos, t2 = t * t;
  return {kMean3 - t2 * t, 1.5f * t2 * sin};
}

struct SinCos {
  float sin, cos;
};

// Of 2 pi t, |t| < 2^22; absolute error below 2e-6. Plain arithmetic: the same bits everywhere.
SinCos sinCosTurns(float t) {
  t -= std::floor(t + 0.5f);                     // [-1/2, 1/2]
  const float folded = 0.25f - std::abs(t);      // cos(2 pi t) = sin(2 pi folded)
  const float s = std::abs(t) > 0.25f ? std::copysign(0.5f, t) - t : t;
  const auto sine = [](float turns) {
    const float x = kTwoPi * turns, x2 = x * x;
    return x * (1.0f + x2 * (-1.66666667e-1f +
                             x2 * (8.33333333e-3f + x2 * (-1.98412698e-4f + x2 * (2.75573192e-6f - x2 * 2.50521084e-8f)))));
  };
  return {sine(s), sine(folded)};
}

struct Place {
  glm::vec3 position{0.0f}, normal{0.0f}, direction{0.0f};
  Varying strength;
};

}  // namespace

struct Synthesis::Pattern {
  Pattern(const Surface& surface, const LayerField& field, const SynthesisSettings& s)
      : settings(s), kernels(surface, field, s.spacing, s.seed, irregularityOf(s.preset)) {}

  Varying height(const Place& place, std::span<const uint32_t> near) const {
    const auto spacing = static_cast<float>(settings.spacing);
    const auto reach = static_cast<float>(Kernels::kReach * settings.spacing);
    const float per_reach2 = 1.0f / (reach * reach), per_spacing = 1.0f / spacing;
    Varying real, imaginary, total, depth, minor, nearby;
    for (const uint32_t k : near) {
      const Kernel& kernel = kernels[k];
      const glm::vec3 step = place.position - kernel.position;
      const float q = 1.0f - glm::dot(step, step) * per_reach2;
      const float facing = std::min(1.5f * glm::dot(place.normal, kernel.normal), 1.0f);
      if (q <= 0.0f || facing <= 0.0f) {
        continue;
      }
      const float agreement = glm::dot(place.direction, kernel.direction);
      const float sign = agreement < 0.0f ? -1.0f : 1.0f;
      const glm::vec3 falling = step * (-2.0f * per_reach2);  // the gradient of q
      const float q2 = q * q, same = facing * agreement * agreement;
      const float weight = same * q2 * q;
      const glm::vec3 weight_gradient = falling * (3.0f * same * q2);
      const SinCos wave = sinCosTurns(sign * (kernel.phase + glm::dot(kernel.direction, step) * per_spacing));
      const glm::vec3 turning = kernel.direction * (sign * kTwoPi * per_spacing * weight);
      real.value += weight * wave.cos;
      real.gradient += weight_gradient * wave.cos - turning * wave.sin;
      imaginary.value += weight * wave.sin;
      imaginary.gradient += weight_gradient * wave.sin + turning * wave.cos;
      total.value += weight;
      total.gradient += weight_gradient;
      // Depths change from line to line, which takes a narrower window.
      const float q4 = q2 * q2, narrow = facing * q4 * q4;
      const glm::vec3 narrow_gradient = falling * (8.0f * facing * q4 * q2 * q);
      nearby.value += narrow;
      nearby.gradient += narrow_gradient;
      depth.value += narrow * kernel.depth;
      depth.gradient += narrow_gradient * kernel.depth;
      minor.value += narrow * kernel.minor;
      minor.gradient += narrow_gradient * kernel.minor;
    }
    const float size2 = real.value * real.value + imaginary.value * imaginary.value;
    if (!(size2 > 1e-12f * total.value * total.value) || !(nearby.value > 0.0f)) {
      return {};
    }
    const float size = std::sqrt(size2);
    const glm::vec3 phase_gradient = (imaginary.gradient * real.value - real.gradient * imaginary.value) / size2;
    const Varying coherent = {size, (real.gradient * real.value + imaginary.gradient * imaginary.value) / size};
    const Varying gain = smoothStep(kBroken, kWhole, quotient(coherent, total)) * quotient(depth, nearby) * place.strength;

    const float cos = real.value / size, sin = imaginary.value / size;
    const auto over = [&](const Profile& p) { return Varying{p.value, phase_gradient * p.slope}; };
    if (settings.preset == Preset::kCloth) {
      return over(cloth(cos, sin)) * gain;
    }
    const Varying small = over(minorCrease(cos, sin)) * quotient(minor, nearby);
    Varying shape = over(skin(cos, sin));
    shape.value += kMinorDepth * small.value;
    shape.gradient += kMinorDepth * small.gradient;
    return shape * gain;
  }

  SynthesisSettings settings;
  Kernels kernels;
};

Synthesis::Synthesis(const Surface& surface, const LayerField& field, const SynthesisSettings& settings)
    : surface_(surface), field_(field) {
  const size_t points = surface.point_positions.size();
  if (!(settings.spacing > 0.0) || !(settings.depth > 0.0) || field.direction.size() != points ||
      field.confidence.size() != points || field.strength.size() != points) {
    throw std::invalid_argument("Synthesis: spacing and depth must be positive, and the field must have an entry a point");
  }
  pattern_ = std::make_unique<Pattern>(surface, field, settings);
}

Synthesis::~Synthesis() = default;

SynthesizedMaps Synthesis::draw(std::span<const uint32_t> parts, uint32_t size, uint32_t threads) const {
  const TexelMap texels = mapTexels(surface_, parts, size, std::max(4u, size / 128u));
  SynthesizedMaps maps;
  const size_t count = static_cast<size_t>(size) * size;
  maps.normal = {size, size, 2, std::vector<float>(2 * count, 0.0f)};
  maps.height = {size, size, 1, std::vector<float>(count, 0.0f)};
  maps.shading = {size, size, 1, std::vector<float>(count, 0.0f)};
  const auto depth = static_cast<float>(pattern_->settings.depth);
  const float darkness = kDarkest / deepest(pattern_->settings.preset);

  const auto drawTexel = [&](size_t texel) {
    const uint32_t t = texels.triangle[texel];
    if (t == kNoIndex) {
      return;
    }
    const glm::vec2 b = texels.barycentric[texel];
    const auto near = pattern_->kernels.near(t, b);
    if (near.empty()) {
      return;
    }
    const glm::vec3 w(1.0f - b.x - b.y, b.x, b.y);
    const glm::uvec3 v = surface_.triangles[t], p = surface_.trianglePoints(t);
    const auto at = [&](const auto& values, const glm::uvec3& i) { return values[i.x] * w.x + values[i.y] * w.y + values[i.z] * w.z; };

    Place place;
    place.strength.value = at(field_.strength, p);
    if (!(place.strength.value > 0.0f)) {
      return;
    }
    const std::array<glm::vec3, 3> corner = {surface_.point_positions[p.x], surface_.point_positions[p.y],
                                             surface_.point_positions[p.z]};
    const glm::vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], cross = glm::cross(e1, e2);
    place.strength.gradient = ((field_.strength[p.y] - field_.strength[p.x]) * glm::cross(e2, cross) +
                               (field_.strength[p.z] - field_.strength[p.x]) * glm::cross(cross, e1)) /
                              glm::dot(cross, cross);
    place.position = corner[0] + e1 * b.x + e2 * b.y;
    place.normal = at(surface_.point_normals, p);
    place.normal = glm::dot(place.normal, place.normal) > 0.0f ? glm::normalize(place.normal) : surface_.point_normals[p.x];
    place.direction = meanLine(field_.direction[p.x], field_.direction[p.y], field_.direction[p.z], w, place.normal);

    const Varying height = pattern_->height(place, near);
    maps.height.pixels[texel] = height.value;
    maps.shading.pixels[texel] = std::clamp(-height.value * darkness, 0.0f, 1.0f);

    const glm::vec3 normal_sum = at(surface_.normals, v);
    const glm::vec3 normal = glm::dot(normal_sum, normal_sum) > 0.0f ? glm::normalize(normal_sum) : surface_.normals[v.x];
    glm::vec3 tangent = glm::vec3(at(surface_.tangents, v));
    tangent -= normal * glm::dot(normal, tangent);
    if (!(glm::dot(tangent, tangent) > 0.0f)) {
      return;  // opposite tangents meet: no frame, so flat
    }
    tangent = glm::normalize(tangent);
    const glm::vec3 bitangent = glm::cross(normal, tangent) * surface_.tangents[v.x].w;
    glm::vec2 slope = depth * glm::vec2(glm::dot(height.gradient, tangent), glm::dot(height.gradient, bitangent));
    const float steepness = glm::length(slope);
    if (!std::isfinite(steepness)) {
      return;
    }
    if (steepness > kSteepest) {
      slope *= kSteepest / steepness;
    }
    const float length = std::sqrt(1.0f + glm::dot(slope, slope));
    maps.normal.pixels[2 * texel] = -slope.x / length;
    maps.normal.pixels[2 * texel + 1] = -slope.y / length;
  };

  std::atomic<uint32_t> next_row = 0;
  const auto work = [&] {
    for (uint32_t row = next_row++; row < size; row = next_row++) {
      for (uint32_t x = 0; x < size; ++x) {
        drawTexel(static_cast<size_t>(row) * size + x);
      }
    }
  };
  std::vector<std::jthread> others;
  for (uint32_t i = 1; i < threads; ++i) {
    others.emplace_back(work);
  }
  work();
  others.clear();
  return maps;
}

}  // namespace furrow::pipeline

#include "pipeline/maps/synthesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "pipeline/maps/kernels.h"
#include "pipeline/parallel.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr float kPi = 3.14159265f;
constexpr float kSteepest = 1.2f;     // slope; the runtime's fast normalisation is good up to 1.22
constexpr float kMinorDepth = 0.22f;  // of a full minor crease, of the whole depth
// Coherence of the waves where lines end, and from which they are at full depth.
constexpr float kBroken = 0.35f, kWhole = 0.8f;

Irregularity irregularityOf(Preset preset) {
  switch (preset) {
    case Preset::kSkin:
      return {.sway = 0.45,
              .sway_length = 5.0,
              .line = 0.5,
              .line_steps = 48,
              .shallowest = 0.06,
              .ending = 0.15,
              .minor = 0.45};
    case Preset::kSkinFine:  // short lines that waver, nearly all with a finer one beside them
      return {.sway = 0.6,
              .sway_length = 2.5,
              .line = 0.5,
              .line_steps = 10,
              .shallowest = 0.1,
              .ending = 0.25,
              .minor = 0.9};
    case Preset::kCloth:
      return {
          .sway = 0.7, .sway_length = 6.0, .line = 0.0, .line_steps = 16, .shallowest = 0.05, .ending = 0.2};
    case Preset::kClothPuckers:  // bulges that end after a few spacings
      return {
          .sway = 0.35, .sway_length = 3.0, .line = 0.0, .line_steps = 4, .shallowest = 0.0, .ending = 0.3};
  }
  return {};
}

// A value over the surface and its gradient.
struct Varying {
  float value = 0.0f;
  glm::vec3 gradient{0.0f};
};

Varying operator*(const Varying& a, const Varying& b) {
  return {a.value * b.value, a.gradient * b.value + b.gradient * a.value};
}

Varying operator+(const Varying& a, const Varying& b) {
  return {a.value + b.value, a.gradient + b.gradient};
}

Varying quotient(const Varying& a, const Varying& b) {
  const float ratio = a.value / b.value;
  return {ratio, (a.gradient - b.gradient * ratio) / b.value};
}

Varying smoothStep(float low, float high, const Varying& v) {
  const float t = std::clamp((v.value - low) / (high - low), 0.0f, 1.0f);
  return {t * t * (3.0f - 2.0f * t), v.gradient * (6.0f * t * (1.0f - t) / (high - low))};
}

// A line across one period of the phase: 1 in its middle, 0 in the other. Even, since the phase of a line
// field has no sign.
struct Profile {
  float value = 0.0f, slope = 0.0f;  // d value / d phase
};

Profile valley(float cos, float sin) {  // narrow, at half a turn
  const float t = 0.5f - 0.5f * cos, t2 = t * t, t5 = t2 * t2 * t;
  return {0.35f * t2 + 0.65f * t5 * t, (0.7f * t + 3.9f * t5) * 0.5f * sin};
}

Profile minorCrease(float cos, float sin) {  // on the ridge between valleys
  const float t = 0.5f + 0.5f * cos, t2 = t * t;
  return {kMinorDepth * t2 * t, kMinorDepth * -1.5f * t2 * sin};
}

Profile fold(float cos, float sin) {  // round, at no turn
  const float t = 0.5f + 0.5f * cos;
  return {0.55f * t + 0.45f * t * t, -(0.55f + 0.9f * t) * 0.5f * sin};
}

// Heights of skin without a crease and of cloth without a fold, so that the mean is about 0 where both are.
constexpr float kSkinLevel = 0.19f, kClothLevel = -0.25f;

// Kernels side by side for the compiler's vector units; the sums are taken in one order whatever their width.
constexpr size_t kLanes = 8;

struct Batch {
  size_t used = 0;
  float step_x[kLanes]{}, step_y[kLanes]{}, step_z[kLanes]{};
  float direction_x[kLanes]{}, direction_y[kLanes]{}, direction_z[kLanes]{};
  float turns[kLanes]{}, q[kLanes]{}, facing[kLanes]{}, same[kLanes]{}, depth[kLanes]{}, minor[kLanes]{};
};

struct LaneSum {
  float value[kLanes]{}, x[kLanes]{}, y[kLanes]{}, z[kLanes]{};

  Varying total() const {
    Varying sum;
    for (size_t i = 0; i < kLanes; ++i) {
      sum.value += value[i];
      sum.gradient += glm::vec3(x[i], y[i], z[i]);
    }
    return sum;
  }
};

struct Sums {
  LaneSum real, imaginary, total, nearby, depth, minor;
};

// `turns` is how the phase changes over a unit of length, `fall` the gradient of q over the step.
void add(const Batch& b, float radians, float fall, Sums& sums) {
  for (size_t i = 0; i < kLanes; ++i) {
    // sin and cos of half the phase by their series, |x| <= pi / 2, then doubled: plain arithmetic, the same
    // bits everywhere.
    const float t =
        b.turns[i] - static_cast<float>(static_cast<int32_t>(b.turns[i] + std::copysign(0.5f, b.turns[i])));
    const float x = kPi * t, x2 = x * x;
    const float sin_half =
        x * (1.0f + x2 * (-1.66666667e-1f +
                          x2 * (8.33333333e-3f +
                                x2 * (-1.98412698e-4f + x2 * (2.75573192e-6f - x2 * 2.50521084e-8f)))));
    const float cos_half =
        1.0f + x2 * (-0.5f + x2 * (4.16666667e-2f +
                                   x2 * (-1.38888889e-3f + x2 * (2.48015873e-5f - x2 * 2.75573192e-7f))));
    const float sin = 2.0f * sin_half * cos_half, cos = 1.0f - 2.0f * sin_half * sin_half;

    const float q2 = b.q[i] * b.q[i], weight = b.same[i] * q2 * b.q[i],
                weight_fall = 3.0f * fall * b.same[i] * q2;
    const float turning = radians * weight;
    const auto gradient = [&](LaneSum& sum, float along_step, float along_direction) {
      sum.x[i] += along_step * b.step_x[i] + along_direction * b.direction_x[i];
      sum.y[i] += along_step * b.step_y[i] + along_direction * b.direction_y[i];
      sum.z[i] += along_step * b.step_z[i] + along_direction * b.direction_z[i];
    };
    sums.real.value[i] += weight * cos;
    gradient(sums.real, weight_fall * cos, -turning * sin);
    sums.imaginary.value[i] += weight * sin;
    gradient(sums.imaginary, weight_fall * sin, turning * cos);
    sums.total.value[i] += weight;
    gradient(sums.total, weight_fall, 0.0f);
    // Depths change from line to line, which takes a narrower window.
    const float q4 = q2 * q2, narrow = b.facing[i] * q4 * q2,
                narrow_fall = 6.0f * fall * b.facing[i] * q4 * b.q[i];
    sums.nearby.value[i] += narrow;
    gradient(sums.nearby, narrow_fall, 0.0f);
    sums.depth.value[i] += narrow * b.depth[i];
    gradient(sums.depth, narrow_fall * b.depth[i], 0.0f);
    sums.minor.value[i] += narrow * b.minor[i];
    gradient(sums.minor, narrow_fall * b.minor[i], 0.0f);
  }
}

struct Place {
  glm::vec3 position{0.0f}, normal{0.0f}, direction{0.0f};
  Varying strength;
};

}  // namespace

struct Synthesis::Pattern {
  Pattern(const Surface& surface, const LayerField& field, const SynthesisSettings& s)
      : settings(s), kernels(surface, field, s.spacing, s.seed, irregularityOf(s.preset)) {}

  struct Relief {
    Varying height;
    float shading = 0.0f;
  };

  Relief relief(const Place& place, std::span<const uint32_t> near) const {
    const auto spacing = static_cast<float>(settings.spacing);
    const auto reach = static_cast<float>(Kernels::kReach * settings.spacing);
    const float per_reach2 = 1.0f / (reach * reach), per_spacing = 1.0f / spacing;
    Sums sums;
    Batch batch;
    const auto flush = [&] {
      add(batch, 2.0f * kPi * per_spacing, -2.0f * per_reach2, sums);
      batch.used = 0;
    };
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
      const size_t i = batch.used;
      batch.step_x[i] = step.x;
      batch.step_y[i] = step.y;
      batch.step_z[i] = step.z;
      batch.direction_x[i] = sign * kernel.direction.x;
      batch.direction_y[i] = sign * kernel.direction.y;
      batch.direction_z[i] = sign * kernel.direction.z;
      batch.turns[i] = sign * (kernel.phase + glm::dot(kernel.direction, step) * per_spacing);
      batch.q[i] = q;
      batch.facing[i] = facing;
      batch.same[i] = facing * agreement * agreement;
      batch.depth[i] = kernel.depth;
      batch.minor[i] = kernel.minor;
      if (++batch.used == kLanes) {
        flush();
      }
    }
    for (size_t i = batch.used; i < kLanes; ++i) {
      batch.facing[i] = batch.same[i] = 0.0f;
    }
    flush();

    const Varying real = sums.real.total(), imaginary = sums.imaginary.total(), total = sums.total.total(),
                  nearby = sums.nearby.total();
    const bool skin = settings.preset == Preset::kSkin || settings.preset == Preset::kSkinFine;
    const Varying level = {skin ? kSkinLevel : kClothLevel, glm::vec3(0.0f)};
    const float size2 = real.value * real.value + imaginary.value * imaginary.value;
    if (!(size2 > 1e-12f * total.value * total.value) || !(nearby.value > 0.0f)) {
      return {level * place.strength, 0.0f};
    }
    const float size = std::sqrt(size2);
    const float cos = real.value / size, sin = imaginary.value / size;
    const glm::vec3 phase_gradient =
        (imaginary.gradient * real.value - real.gradient * imaginary.value) / size2;
    const auto shape = [&](const Profile& p) { return Varying{p.value, phase_gradient * p.slope}; };
    const Varying coherent = {size,
                              (real.gradient * real.value + imaginary.gradient * imaginary.value) / size};
    const Varying whole = smoothStep(kBroken, kWhole, quotient(coherent, total));
    const Varying depth = whole * quotient(sums.depth.total(), nearby);
    if (!skin) {
      const Varying folds = shape(fold(cos, sin)) * depth;
      const float valley_floor = (1.0f - folds.value) * depth.value;
      return {(level + folds) * place.strength,
              kDarkest * place.strength.value * valley_floor * valley_floor};
    }
    Varying creases = shape(valley(cos, sin)) * depth +
                      shape(minorCrease(cos, sin)) * whole * quotient(sums.minor.total(), nearby);
    const float shading = kDarkest * place.strength.value * std::min(creases.value, 1.0f);
    creases = {-creases.value, -creases.gradient};
    return {(level + creases) * place.strength, shading};
  }

  SynthesisSettings settings;
  Kernels kernels;
};

Synthesis::Synthesis(const Surface& surface, const LayerField& field, const SynthesisSettings& settings)
    : surface_(surface), field_(field) {
  const size_t points = surface.point_positions.size();
  if (!(settings.spacing > 0.0) || !(settings.depth > 0.0) || field.direction.size() != points ||
      field.confidence.size() != points || field.strength.size() != points) {
    throw std::invalid_argument(
        "Synthesis: spacing and depth must be positive, and the field must have an entry a point");
  }
  pattern_ = std::make_unique<Pattern>(surface, field, settings);
}

Synthesis::~Synthesis() = default;

SynthesizedMaps Synthesis::draw(const TexelMap& texels, uint32_t threads) const {
  const uint32_t width = texels.grid.width, height = texels.grid.height;
  const size_t count = texels.triangle.size();
  SynthesizedMaps maps;
  maps.normal = {width, height, 2, std::vector<float>(2 * count, 0.0f)};
  maps.height = {width, height, 1, std::vector<float>(count, 0.0f)};
  maps.shading = {width, height, 1, std::vector<float>(count, 0.0f)};
  const auto depth = static_cast<float>(pattern_->settings.depth);

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
    const glm::uvec3 p = surface_.trianglePoints(t);
    const auto at = [&](const auto& values, const glm::uvec3& i) {
      return values[i.x] * w.x + values[i.y] * w.y + values[i.z] * w.z;
    };

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
    place.normal = glm::dot(place.normal, place.normal) > 0.0f ? glm::normalize(place.normal)
                                                               : surface_.point_normals[p.x];
    place.direction =
        meanLine(field_.direction[p.x], field_.direction[p.y], field_.direction[p.z], w, place.normal);

    const auto [relief, shading] = pattern_->relief(place, near);
    maps.height.pixels[texel] = relief.value;
    maps.shading.pixels[texel] = shading;

    const auto frame = frameAt(surface_, t, b);
    if (!frame) {
      return;
    }
    glm::vec2 slope = depth * glm::vec2(glm::dot(relief.gradient, frame->tangent),
                                        glm::dot(relief.gradient, frame->bitangent));
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

  parallelFor(height, threads, [&](uint32_t row) {
    for (uint32_t x = 0; x < width; ++x) {
      drawTexel(static_cast<size_t>(row) * width + x);
    }
  });
  return maps;
}

}  // namespace furrow::pipeline

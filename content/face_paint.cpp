#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "content/face_parts.h"
#include "content/head.h"
#include "content/noise.h"

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();

double spot(dvec3 p, dvec2 centre, dvec2 radii) {
  const dvec2 q = (dvec2(p) - centre) / radii;
  return std::exp(-glm::dot(q, q));
}

// Piecewise linear through (x, y) pairs with ascending x.
double along(std::initializer_list<dvec2> nodes, double x) {
  const dvec2* last = nodes.begin();
  for (const dvec2& node : nodes) {
    if (x <= node.x)
      return node.x > last->x ? glm::mix(last->y, node.y, (x - last->x) / (node.x - last->x)) : node.y;
    last = &node;
  }
  return last->y;
}

// A unit tangent of the head at p along `wish`.
glm::vec3 tangent(dvec3 p, dvec3 wish) {
  const dvec3 n = head::normal(p);
  const dvec3 t = wish - n * glm::dot(n, wish);
  return glm::length(t) > 1e-3 ? glm::vec3(glm::normalize(t)) : glm::vec3(0, 1, 0);
}

// The head with its ears, where they matter.
double solid(dvec3 p) {
  const dvec3 m(std::abs(p.x), p.y, p.z);
  const double d = head::distance(p);
  const bool by_ear = m.x > 5.0 && m.y < 2.0 && m.y > -7.5 && m.z < -4.5 && m.z > -12.0;
  return by_ear ? std::min(d, earDistance(m)) : d;
}

// How much of the sky a point sees past the head itself, about.
double openness(dvec3 p, dvec3 n) {
  double closed = 0, weight = 0.5;
  for (const double reach : {0.35, 0.8, 1.7, 3.2}) {
    closed += weight * std::max(0.0, reach - solid(p + reach * n)) / reach;
    weight *= 0.62;
  }
  return std::clamp(1 - closed, 0.0, 1.0);
}

}  // namespace

double lipsAt(dvec3 p) {
  const double x = std::abs(p.x);
  if (x > head::kMouth + 0.1 || p.z < 0) return 0;
  const dvec2 borders = head::lipBorders(std::min(x, head::kMouth));
  const double soft = 0.09, corner = smoothRamp(head::kMouth + 0.1, head::kMouth - 0.25, x);
  return corner * smoothRamp(borders.x + soft, borders.x - soft, p.y) *
         smoothRamp(borders.y - soft, borders.y + soft, p.y);
}

double hairAt(dvec3 p) {
  const double turn = std::atan2(std::abs(p.x), p.z + 7.0);
  const double line = along({{0.0, 6.9},
                             {0.25, 7.1},
                             {0.5, 7.0},
                             {0.75, 6.1},
                             {0.95, 5.0},
                             {1.08, 3.2},
                             {1.17, 0.6},
                             {1.23, -2.0},
                             {1.30, -2.7},
                             {1.40, -2.6},
                             {1.44, 1.0},
                             {1.9, 1.2},
                             {2.0, -0.6},
                             {2.15, -4.6},
                             {2.5, -7.2},
                             {3.2, -7.6}},
                            turn);
  const double ragged = 0.35 * valueNoise(p * 1.7);
  return smoothRamp(-0.25, 0.75, p.y - line + ragged);
}

double browAt(dvec3 p) {
  const double x = std::abs(p.x), t = (x - 1.0) / (5.0 - 1.0);
  if (p.y < 0.9 || p.y > 3.5 || p.z < -1.5) return 0;
  const double middle = 1.62 + 0.62 * std::sin(kPi * std::clamp(0.06 + 0.70 * t, 0.0, 1.0)) - 0.42 * t * t;
  const double half = 0.34 * std::min({1.0, 0.75 + 1.6 * t, 0.28 + 1.3 * (1 - t)});
  return smoothRamp(half + 0.07, half - 0.12, std::abs(p.y - middle)) * smoothRamp(-0.06, 0.1, t) *
         smoothRamp(1.04, 0.88, t);
}

Painting paintingAt(dvec3 p) {
  const dvec3 m(std::abs(p.x), p.y, p.z);
  const double mirror = p.x < 0 ? -1.0 : 1.0;
  const double in_front = smoothRamp(-4.0, -2.0, p.z);
  const double forehead =
      smoothRamp(1.9, 3.0, m.y) * smoothRamp(7.2, 5.6, m.y) * smoothRamp(5.9, 3.4, m.x) * in_front;
  const double glabella = smoothRamp(1.0, 0.25, glm::length(dvec2(m.x / 1.7, (m.y - 1.9) / 1.9)));

  const dvec2 from_corner = dvec2(m) - dvec2(head::kEyeOuter - 0.35, 0.0);
  const double reach = glm::length(from_corner), angle = std::atan2(from_corner.y, from_corner.x);
  const double crow = smoothRamp(0.35, 0.9, reach) * smoothRamp(2.6, 1.3, reach) *
                      smoothRamp(1.35, 0.6, std::abs(angle + 0.1)) * in_front;
  const double under_eye = smoothRamp(1.0, 0.4, glm::length(dvec2((m.x - 3.3) / 2.2, (m.y + 1.15) / 0.8))) *
                           smoothRamp(-0.5, -0.75, m.y);

  const double bunny = smoothRamp(1.0, 0.35, glm::length(dvec2((m.x - 0.65) / 1.15, (m.y + 1.1) / 1.5))) *
                       smoothRamp(0.0, 1.0, m.z);

  const auto [beside, across] = head::nasolabialFold(dvec2(m));
  const double distance = std::abs(beside - 0.05);
  const double mouth = smoothRamp(0.95, 0.1, distance) * smoothRamp(-2.9, -4.3, m.y) *
                       smoothRamp(-8.6, -6.8, m.y) * smoothRamp(1.0, 1.7, m.x) * smoothRamp(-3.0, -1.0, m.z);
  const double chin =
      smoothRamp(1.0, 0.4, glm::length(dvec2(m.x / 2.1, (m.y + 9.6) / 1.5))) * smoothRamp(-1.0, 0.5, m.z);
  const double about_lips =
      smoothRamp(1.0, 0.45, glm::length(dvec2(m.x / 2.7, (m.y + 6.95) / 1.75))) * smoothRamp(-0.5, 0.5, m.z);

  const double neck = smoothRamp(-10.9, -11.8, m.y + 0.3 * m.z + 0.9) * smoothRamp(7.2, 4.8, m.x) *
                      smoothRamp(-11.0, -8.0, m.z);

  Painting result;
  result.mask_a = glm::vec4(forehead, glabella, std::max(crow, 0.75 * under_eye), bunny);
  result.mask_b = glm::vec4(mouth, chin, about_lips, neck);
  // Beside the corner of the eye creases are spokes of it; under the eye they run along the lid.
  const dvec3 about(-from_corner.y * mirror, from_corner.x, 0.0);
  result.eye = tangent(p, reach > 1e-6 ? glm::mix(dvec3(0.15 * mirror, 1, 0), glm::normalize(about),
                                                  smoothRamp(-0.2, 0.4, from_corner.x))
                                       : dvec3(0, 1, 0));
  // Bunny lines run down the flanks from the bridge.
  result.nose = tangent(p, {0.55 * mirror * smoothRamp(0.0, 0.5, m.x), 1, 0});
  result.mouth = tangent(p, {across.x * mirror, across.y, 0});

  // Lines that never leave: two on the forehead, one under each eye, a trace of the nasolabial fold.
  result.bias = glm::vec3(
      0.5 +
      in_front * dvec3(0.04 * std::exp(-std::pow((m.y - 4.4 - 0.12 * std::cos(m.x)) / 0.55, 2)) *
                           smoothRamp(4.2, 2.4, m.x),
                       0.10 * under_eye,
                       0.34 * std::exp(-std::pow(distance / 0.45, 2)) * mouth * smoothRamp(-8.2, -6.6, m.y)));
  return result;
}

dvec3 skinColor(dvec3 p) {
  constexpr dvec3 kHairColor(0.030, 0.018, 0.012);
  // Roots show one by one along the hairline.
  const double thick = hairAt(p), turn = std::atan2(p.x, p.z + 7.0);
  const double roots = valueNoise({turn * 80, p.y * 1.6, 3}) + 0.7 * valueNoise({turn * 170, p.y * 2.5, 7});
  const double hair = smoothRamp(0.2, 0.9, thick + 2.6 * roots * thick * (1 - thick)), brow = browAt(p);
  if (hair == 1) return kHairColor;
  const dvec3 m(std::abs(p.x), p.y, p.z);
  dvec3 color(0.60, 0.365, 0.265);
  const auto tint = [&](dvec3 by, double amount) {
    color *= glm::mix(dvec3(1), by, std::clamp(amount, 0.0, 1.0));
  };
  const double face = smoothRamp(-5.0, -1.0, p.z);
  tint({1.03, 0.82, 0.78}, 0.9 * spot(m, {3.9, -2.9}, {2.1, 1.7}) * face);                 // cheeks
  tint({1.03, 0.78, 0.74}, spot(m, {0.0, -3.6}, {1.3, 0.9}) * smoothRamp(1.5, 3.0, p.z));  // nose
  tint({1.03, 0.80, 0.78}, 0.7 * spot(m, {1.5, -4.2}, {0.5, 0.5}) * face);                 // its wings
  tint({1.02, 0.86, 0.84}, 0.7 * spot(m, {0.0, -10.3}, {1.7, 1.0}) * face);                // chin
  tint({1.04, 1.04, 0.98}, 0.8 * spot(m, {0.0, 4.6}, {4.2, 2.2}) * face);                  // forehead
  tint({0.97, 0.97, 0.99}, 0.8 * smoothRamp(-7.6, -9.4, p.y) * smoothRamp(-13.0, -10.5, p.y) * face);  // jaw
  const double eye = spot(m, {3.1, -0.1}, {1.75, 0.95}) * smoothRamp(-1.0, 0.3, p.z);
  tint({0.86, 0.72, 0.74}, 0.8 * eye);
  tint({0.84, 0.76, 0.80}, 0.55 * spot(m, {2.7, -1.05}, {1.3, 0.42}) * face);  // under the eye
  if (m.x > head::kEyeInner - 0.1 && m.x < head::kEyeOuter + 0.1 && std::abs(p.y) < 1 && p.z > 0) {
    const dvec2 margins = head::lidMargins(m.x);
    const double upper = std::exp(-std::pow((p.y - margins.x) / 0.09, 2)),
                 lower = std::exp(-std::pow((p.y - margins.y) / 0.09, 2));
    tint({0.62, 0.42, 0.40}, upper);
    tint({0.92, 0.66, 0.62}, lower);
  }
  const double lips = lipsAt(p);
  const double streak = 1 + 0.10 * valueNoise({p.x * 9, p.y * 1.5, p.z * 2});
  color = glm::mix(color, dvec3(0.46, 0.185, 0.165) * streak, 0.92 * lips);
  color *= glm::mix(1.0, 0.72,
                    lips * smoothRamp(0.16, 0.0, std::abs(p.y - head::lipLine(m.x))));  // where they meet

  // Blotches, and a few freckles.
  tint({1.03, 0.90, 0.88}, 0.5 + 0.7 * valueNoise(p * 0.9));
  color *= 1.0 + 0.035 * valueNoise(p * 2.6) + 0.03 * valueNoise(p * 6.5);
  const double freckles = smoothRamp(0.34, 0.16, cells(p / 0.4).nearest) *
                          smoothRamp(-0.2, 0.6, valueNoise(p * 0.8)) *
                          std::max(spot(m, {2.8, -2.2}, {2.4, 1.2}), 0.5 * spot(m, {0, -2.0}, {1.0, 1.6}));
  tint({0.80, 0.66, 0.55}, 0.45 * freckles * face);

  tint({0.42, 0.33, 0.28}, 0.8 * brow);
  return glm::mix(color, kHairColor, hair);
}

dvec3 skinOcclusion(dvec3 p, dvec3 normal) {
  const double open = openness(p, normal);
  // Light that comes back from skin is red: the red of what is shaded falls last.
  return glm::pow(dvec3(std::max(open, 0.05)), dvec3(0.42, 0.62, 0.66));
}

}  // namespace furrow::content

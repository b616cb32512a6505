#include "content/head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "content/solids.h"

namespace furrow::content::head {

using glm::dvec2;
using glm::dvec3;

// The masses take their proportions from measured heads; the features are drawn on them.
double distance(dvec3 p) {
  const dvec3 q(std::sqrt(p.x * p.x + 0.01), p.y, p.z);

  // Skull, face, muzzle, jaw, chin.
  double d = ellipsoid(q, {0.3, 2.1, -7.7}, {7.8, 9.0, 10.0});
  d = join(d, ellipsoid(q, {0.2, -3.3, -3.4}, {6.7, 7.2, 5.2}), 2.0);
  d = join(d, ellipsoid(q, {0.0, -6.6, 0.35}, {3.0, 3.4, 3.0}), 2.5);
  d = join(d, limb(q, {4.6, -7.4, -4.2}, {1.1, -10.2, 0.6}, 1.2, 1.45), 2.2);
  d = join(d, limb(q, {6.0, -2.5, -5.8}, {5.0, -7.0, -4.2}, 1.2, 1.0), 1.7);
  d = join(d, ellipsoid(q, {0.0, -10.25, 1.35}, {1.7, 1.3, 1.4}), 1.3);

  // Neck: its trunk, the floor of the mouth, the muscle from behind the ear to the collarbone, shoulders.
  double neck = limb(q, {0.0, -5.5, -8.1}, {0.0, -17.8, -9.3}, 5.6, 5.0);
  neck = join(neck, limb(q, {0.0, -8.6, -1.9}, {0.0, -12.8, -5.6}, 2.3, 2.4), 2.8);
  neck = join(neck, limb(q, {6.0, -4.0, -9.2}, {1.3, -15.5, -4.2}, 1.0, 0.45), 1.2);
  neck = join(neck, limb(q, {2.5, -8.4, -11.6}, {11.3, -20.0, -10.8}, 1.6, 2.0), 4.0);
  // No ridge down the breast, where the shoulders meet.
  const dvec3 wide(std::sqrt(p.x * p.x + 12.0), p.y, p.z);
  neck = join(neck, limb(wide, {0.0, -22.0, -8.3}, {15.8, -22.0, -9.0}, 4.9, 4.3), 4.0);
  d = join(d, neck, 3.0);

  // Cheekbones and cheeks.
  d = join(d, limb(q, {4.8, -2.3, -0.6}, {6.2, -1.5, -4.5}, 0.8, 0.8), 2.1);
  d = join(d, ellipsoid(q, {3.2, -3.5, 0.1}, {1.8, 1.6, 1.2}), 1.9);
  d = join(d, ellipsoid(q, {3.2, -6.2, -1.3}, {1.5, 3.0, 2.4}), 2.9);

  // Brows and sockets, the lids that hug the eyeball, and the crease over the upper one.
  d = join(d, limb(q, {0.6, 2.1, 1.5}, {3.3, 2.0, 1.05}, 0.85, 0.5), 1.7);
  d = join(d, limb(q, {2.9, 2.4, 1.0}, {5.1, 1.3, -0.9}, 0.65, 0.42), 2.6);
  d = carve(d, ellipsoid(q, {3.05, 0.0, 2.25}, {1.8, 1.2, 1.2}), 1.2);
  d = join(d, glm::distance(q, kEye) - kLid, 0.5);
  if (q.x > kEyeInner && q.x < kEyeOuter + 0.4 && q.z > 0) {
    const double t = (q.x - kEyeInner) / (kEyeOuter - kEyeInner);
    const double arch = std::sin(glm::pi<double>() * std::clamp(std::pow(t, 0.8), 0.0, 1.0));
    const double fold = (q.y - lidMargins(q.x).x - 0.12 - 0.24 * arch) / 0.10;
    d += 0.085 * std::exp(-fold * fold) * std::pow(std::max(std::sin(glm::pi<double>() * t), 0.0), 0.6);
    const double bag = (q.y - lidMargins(q.x).y + 0.55 + 0.2 * arch) / 0.2;
    d += 0.03 * std::exp(-bag * bag) * std::max(std::sin(glm::pi<double>() * t), 0.0);
  }

  // Nose: bridge, flanks, tip, wings with their crease, septum; then the nostrils.
  d = join(d, limb(q, {0.0, 0.8, 1.6}, {0.0, -2.9, 3.95}, 0.42, 0.66), 1.05);
  d = join(d, limb(q, {0.5, -0.6, 1.9}, {0.85, -3.3, 3.1}, 0.4, 0.55), 1.6);
  d = join(d, ellipsoid(q, {0.0, -3.5, 4.05}, {0.9, 0.73, 0.8}), 0.8);
  d = join(d, ellipsoid(q, {1.15, -3.95, 3.0}, {0.6, 0.56, 0.9}), 1.0);
  d = join(d, limb(q, {0.0, -4.0, 4.0}, {0.0, -4.65, 3.0}, 0.34, 0.44), 0.7);
  d = carve(d, limb(q, {1.6, -3.2, 2.95}, {1.95, -4.3, 2.5}, 0.04, 0.06), 0.3);
  d = carve(d, ellipsoid(q, {0.66, -4.62, 3.3}, {0.32, 0.42, 0.55}), 0.2);

  // Philtrum, lips, the fold over the chin, corners of the mouth.
  d = carve(d, limb(q, {0.0, -5.0, 3.75}, {0.0, -5.95, 3.95}, 0.2, 0.28), 0.5);
  d = join(d, limb(q, {0.3, -6.5, 3.12}, {1.3, -6.64, 2.66}, 0.40, 0.38), 0.45);
  d = join(d, limb(q, {1.3, -6.64, 2.66}, {2.5, -6.98, 1.85}, 0.38, 0.16), 0.45);
  d = join(d, limb(q, {0.0, -7.5, 2.95}, {1.2, -7.43, 2.6}, 0.50, 0.44), 0.35);
  d = join(d, limb(q, {1.2, -7.43, 2.6}, {2.4, -7.06, 1.9}, 0.44, 0.16), 0.35);
  d = carve(d, limb(q, {0.0, -8.6, 3.55}, {1.2, -8.45, 3.2}, 0.35, 0.25), 0.9);
  d = carve(d, ellipsoid(q, {2.8, -7.02, 2.5}, {0.25, 0.25, 0.35}), 0.5);
  return d;
}

dvec3 normal(dvec3 p) {
  constexpr double e = 1e-3;
  const dvec3 a(1, -1, -1), b(-1, -1, 1), c(-1, 1, -1), d(1, 1, 1);
  return glm::normalize(a * distance(p + e * a) + b * distance(p + e * b) + c * distance(p + e * c) +
                        d * distance(p + e * d));
}

dvec3 onto(dvec3 p, int steps, double offset) {
  for (int step = 0; step < steps; ++step) p -= normal(p) * (distance(p) - offset) * 0.9;
  return p;
}

dvec3 trace(dvec3 from, dvec3 direction, double offset) {
  double t = 0;
  for (int step = 0; step < 200; ++step) {
    const double d = distance(from + t * direction) - offset;
    if (std::abs(d) < 1e-5) break;
    t += 0.7 * d;
  }
  return from + t * direction;
}

dvec2 lidMargins(double x) {
  const double t = std::clamp((x - kEyeInner) / (kEyeOuter - kEyeInner), 0.0, 1.0);
  const double corner_line = glm::mix(-0.16, 0.06, t);
  const double upper = std::pow(std::sin(glm::pi<double>() * std::pow(t, 0.88)), 0.8);
  const double lower = std::pow(std::sin(glm::pi<double>() * std::pow(t, 1.15)), 0.85);
  return {corner_line + 0.52 * upper, corner_line - 0.45 * lower};
}

double lipLine(double x) {
  const double u = std::min(std::abs(x) / kMouth, 1.5);
  return -7.0 - 0.05 * std::exp(-u * u * 14) + 0.06 * std::sin(glm::pi<double>() * std::min(u, 1.0)) +
         0.01 * u * u;
}

dvec2 lipBorders(double x) {
  const double u = std::min(std::abs(x) / kMouth, 1.0);
  const double bow = 0.62 + 0.12 * std::exp(-(u - 0.2) * (u - 0.2) * 60) - 0.05 * std::exp(-u * u * 120);
  const double upper = bow * std::pow(1 - u * u, 0.8) * (1 - 0.25 * u);
  const double lower = 0.86 * std::pow(1 - u * u, 0.75);
  const double line = lipLine(x);
  return {line + upper, line - lower};
}

// From the wing of the nose past the corner of the mouth.
constexpr std::array<dvec2, 6> kFold{
    {{1.75, -3.5}, {2.3, -4.6}, {2.9, -5.8}, {3.3, -6.9}, {3.35, -8.0}, {3.0, -9.0}}};

Fold nasolabialFold(dvec2 p) {
  Fold fold{1e9, dvec2(0)};
  dvec2 along(0);
  double side = 0;
  for (size_t k = 0; k + 1 < kFold.size(); ++k) {
    const dvec2 a = kFold[k], b = kFold[k + 1], e = b - a;
    const double t = std::clamp(glm::dot(p - a, e) / glm::dot(e, e), 0.0, 1.0);
    const double distance = glm::distance(p, glm::mix(a, b, t)),
                 weight = 1 / (0.05 + distance * distance * distance);
    fold.distance = std::min(fold.distance, distance);
    along += glm::normalize(e) * weight;
    side += (e.x * (p.y - a.y) - e.y * (p.x - a.x)) * weight;
  }
  along = glm::normalize(along);
  fold.across = {-along.y, along.x};
  if (side < 0) fold.distance = -fold.distance;
  return fold;
}

}  // namespace furrow::content::head

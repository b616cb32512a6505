#include "content/head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

namespace furrow::content::head {
namespace {

using glm::dvec2;
using glm::dvec3;

double ellipsoid(dvec3 p, dvec3 centre, dvec3 radii) {
  const dvec3 q = (p - centre) / radii;
  const double k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

// A limb whose radius goes from ra at a to rb at b.
double limb(dvec3 p, dvec3 a, dvec3 b, double ra, double rb) {
  const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
  return glm::distance(p, glm::mix(a, b, t)) - glm::mix(ra, rb, t);
}

// Union with a fillet about k wide [Quilez, smooth minimum, cubic].
double join(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * h * k / 6;
}

double carve(double a, double b, double k) {
  return -join(-a, b, k);
}

}  // namespace

double distance(dvec3 p) {
  const dvec3 q(std::sqrt(p.x * p.x + 0.01), p.y, p.z);

  // Skull, face, jaw, neck.
  double d = ellipsoid(q, {0, 2.7, -7.3}, {7.45, 9.1, 9.2});
  d = join(d, ellipsoid(q, {0, -4.0, -3.4}, {5.8, 7.0, 5.0}), 2.0);
  d = join(d, limb(q, {4.6, -7.2, -4.6}, {0.9, -10.25, 0.4}, 1.2, 1.25), 2.2);
  d = join(d, ellipsoid(q, {0, -10.05, 1.05}, {1.5, 1.2, 1.15}), 1.5);
  d = join(d, limb(q, {0, -8.0, -6.4}, {0, -19.0, -7.4}, 4.8, 5.5), 2.2);
  d = carve(d, q.y + 16.9, 5.0);

  // Cheekbones, cheeks, temples.
  d = join(d, limb(q, {4.5, -2.2, -0.6}, {5.7, -1.7, -4.5}, 0.95, 0.9), 2.2);
  d = join(d, ellipsoid(q, {3.3, -3.5, 0.35}, {1.7, 1.6, 1.2}), 2.0);
  d = join(d, ellipsoid(q, {4.1, -5.9, -1.35}, {1.55, 2.5, 2.2}), 2.4);
  d = carve(d, ellipsoid(q, {9.2, 2.8, -1.8}, {1.9, 2.4, 3.2}), 2.2);

  // Muzzle under the nose.
  d = join(d, ellipsoid(q, {0, -6.9, 0.1}, {2.7, 2.4, 2.25}), 1.8);

  // Brows and sockets, the lids that hug the eyeball, and the fold over the upper one.
  d = join(d, limb(q, {0.7, 1.55, 1.0}, {3.2, 2.1, 0.5}, 0.72, 0.62), 1.2);
  d = join(d, limb(q, {3.2, 2.1, 0.5}, {5.2, 0.7, -1.9}, 0.62, 0.6), 2.2);
  d = carve(d, ellipsoid(q, {3.1, 0.15, 1.75}, {1.75, 1.15, 1.25}), 1.1);
  d = join(d, glm::distance(q, kEye) - kLid, 0.55);
  if (q.x > kEyeInner && q.x < kEyeOuter && q.z > 0) {
    const double t = (q.x - kEyeInner) / (kEyeOuter - kEyeInner);
    const double line = lidMargins(q.x).x + 0.10 + 0.26 * std::sin(glm::pi<double>() * std::pow(t, 0.8));
    const double fold = (q.y - line) / 0.13;
    d += 0.07 * std::exp(-fold * fold) * std::sin(glm::pi<double>() * t);
  }

  // Nose: bridge, flanks, tip, wings, septum; then the nostrils.
  d = join(d, limb(q, {0, 0.9, 0.95}, {0, -3.3, 2.85}, 0.62, 0.72), 1.0);
  d = join(d, limb(q, {0.5, -1.6, 1.3}, {0.95, -3.6, 1.85}, 0.42, 0.58), 1.5);
  d = join(d, ellipsoid(q, {0, -3.75, 3.1}, {0.86, 0.72, 0.8}), 0.8);
  d = join(d, ellipsoid(q, {1.05, -4.08, 2.2}, {0.60, 0.55, 0.85}), 0.75);
  d = join(d, limb(q, {0, -4.2, 3.0}, {0, -4.55, 2.1}, 0.36, 0.42), 0.7);
  d = carve(d, ellipsoid(q, {0.62, -4.62, 2.5}, {0.30, 0.34, 0.50}), 0.22);

  // Philtrum, lips, the fold over the chin, corners of the mouth.
  d = carve(d, limb(q, {0, -5.15, 2.95}, {0, -5.95, 2.95}, 0.22, 0.3), 0.5);
  d = join(d, limb(q, {0.35, -6.52, 2.2}, {1.3, -6.62, 1.85}, 0.42, 0.4), 0.4);
  d = join(d, limb(q, {1.3, -6.62, 1.85}, {2.5, -6.98, 1.0}, 0.4, 0.16), 0.4);
  d = join(d, limb(q, {0.0, -7.5, 2.1}, {1.2, -7.42, 1.8}, 0.5, 0.44), 0.35);
  d = join(d, limb(q, {1.2, -7.42, 1.8}, {2.4, -7.05, 1.05}, 0.44, 0.16), 0.35);
  d = carve(d, limb(q, {0, -8.55, 2.75}, {1.2, -8.4, 2.35}, 0.35, 0.25), 0.9);
  d = carve(d, ellipsoid(q, {2.8, -7.0, 1.65}, {0.25, 0.25, 0.35}), 0.5);
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
  return {corner_line + 0.45 * upper, corner_line - 0.42 * lower};
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

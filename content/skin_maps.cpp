#include "content/skin_maps.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "content/head.h"
#include "content/noise.h"
#include "content/solids.h"
#include "content/surface_texels.h"

namespace furrow::content {
namespace {

using glm::dvec3;

constexpr uint32_t kSize = 2048;

double around(dvec3 p, double x, double y, double rx, double ry) {
  const double u = (std::abs(p.x) - x) / rx, v = (p.y - y) / ry;
  return std::exp(-u * u - v * v);
}

// How coarse the pores are: most on the nose and beside it, hardly on the lids, not at all on the lips.
double coarseness(dvec3 p) {
  const double front = smoothRamp(-6.0, -2.0, p.z);
  const double face = 0.45 + 0.75 * around(p, 0, -3.2, 1.9, 2.0) + 0.5 * around(p, 2.6, -3.4, 2.0, 1.8) +
                      0.2 * around(p, 0, 4.0, 4.0, 2.0) + 0.3 * around(p, 0, -9.8, 2.0, 1.2);
  const double lids = around(p, 3.1, 0.0, 1.7, 0.9) * smoothRamp(-1.0, 0.3, p.z);
  return glm::mix(0.35, face, front) * (1 - 0.8 * lids) * (1 - lipsAt(p)) * (1 - 0.6 * hairAt(p));
}

// A pore's depth at p, [0, 1].
double poreAt(dvec3 p) {
  constexpr double kApart = 0.105, kRadius = 0.034;
  return bump(cells(p / kApart).nearest * kApart / kRadius);
}

// Centimetres.
double relief(dvec3 p) {
  if (hairAt(p) == 1) return 0;
  const double coarse = coarseness(p);
  double height = -0.0065 * coarse * poreAt(p);
  const Cells net = cells(p / 0.07);
  height -= 0.0013 * (0.4 + 0.6 * coarse) * smoothRamp(0.28, 0.0, net.second - net.nearest);
  height += 0.004 * coarse * valueNoise(p * 4.5);
  const double lips = lipsAt(p);
  if (lips > 0) {
    const double bent = p.x + 0.06 * valueNoise(p * dvec3(3, 6, 0)) + 0.03 * p.x * (p.y + 7.0);
    height -= 0.010 * lips * smoothRamp(0.5, 0.0, std::abs(valueNoise({bent * 8.0, 0.6 * p.y, 0})));
  }
  return height;
}

// 1 inside the nostrils, whose walls no light of a preview is kept from.
double nostrilAt(dvec3 p) {
  const double wall = ellipsoid({std::abs(p.x), p.y, p.z}, {0.66, -4.62, 3.3}, {0.32, 0.42, 0.55});
  return smoothRamp(0.12, 0.01, wall) * smoothRamp(-4.84, -4.55, p.y);
}

// Where a beard would grow.
double beardAt(dvec3 p) {
  const double jaw = smoothRamp(-4.9, -6.2, p.y + 0.22 * std::max(0.0, std::abs(p.x) - 4.5)) *
                     smoothRamp(-13.0, -10.8, p.y) * smoothRamp(-7.5, -4.5, p.z);
  return jaw * (1 - 0.9 * around(p, 3.6, -4.6, 1.9, 1.5)) * (1 - lipsAt(p)) *
         (1 - around(p, 0, -8.3, 1.6, 0.35) * 0.6);
}

dvec3 painted(dvec3 p) {
  dvec3 color = skinColor(p);
  if (hairAt(p) == 1) return color;
  color *= glm::mix(1.0, 0.10, nostrilAt(p));
  color *= 1 - 0.16 * std::min(1.0, coarseness(p)) * poreAt(p);
  color *= 1 + 0.03 * valueNoise(p * 15.0) + 0.02 * valueNoise(p * 31.0);
  const double beard = beardAt(p);
  if (beard > 0) {
    color *= glm::mix(dvec3(1), dvec3(0.88, 0.91, 0.93), beard);
    color *=
        glm::mix(dvec3(1), dvec3(0.72, 0.72, 0.75),
                 beard * smoothRamp(0.5, 0.2, cells(p / 0.062).nearest) * (0.7 + 0.3 * valueNoise(p * 2.0)));
  }
  return color;
}

}  // namespace

SkinMaps skinMaps(const FacePart& skin) {
  const SurfaceTexels texels(skin.mesh, skin.materials, kSkin, kSize);
  return {texels.colors(painted), texels.normals(relief)};
}

}  // namespace furrow::content

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "content/face_parts.h"
#include "content/head.h"
#include "content/noise.h"

// Hairs and locks of hair: ribbons that taper to a point.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();

// A ribbon along `spine`, `width` wide at its root, which goes with `root`.
void addRibbon(FacePart& part, const std::vector<dvec3>& spine, double width, const HeadPoint& root,
               dvec3 color, double turn, uint32_t material) {
  std::array<uint32_t, 2> last{};
  const size_t count = spine.size();
  for (size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(count - 1);
    const dvec3 along = glm::normalize(spine[std::min(k + 1, count - 1)] - spine[k > 0 ? k - 1 : 0]);
    const dvec3 out = head::normal(spine[k]);
    const dvec3 flat = glm::normalize(glm::cross(along, out));
    const dvec3 side =
        glm::normalize(flat + turn * out) * (0.5 * width * std::min(1.0, 0.3 + 3 * t) * (1 - 0.85 * t * t));
    std::array<uint32_t, 2> now{};
    for (int s = 0; s < 2; ++s) {
      const dvec3 p = spine[k] + (s ? side : -side);
      part.mesh.points.push_back(p);
      HeadPoint mover = root;
      mover.offset = p - root.position;
      part.points.push_back(mover);
      part.colors.push_back(color * glm::mix(0.75, 1.15, t));
      now[s] = part.mesh.addVertex(static_cast<uint32_t>(part.mesh.points.size() - 1),
                                   {0.25 + 0.5 * s, 0.02 + 0.96 * t});
    }
    if (k > 0) part.mesh.addQuad(last[0], last[1], now[1], now[0]);
    last = now;
  }
  part.materials.resize(part.mesh.triangles.size(), material);
}

dvec3 tangential(dvec3 v, dvec3 normal) {
  return glm::normalize(v - normal * glm::dot(v, normal));
}

}  // namespace

FacePart brows() {
  FacePart part;
  Random random(11);
  for (int hair = 0; hair < 4000 && part.materials.size() < 380 * 4; ++hair) {
    const double x = random.between(0.85, 5.1), y = random.between(1.0, 2.8);
    const double keep = random.next(), bend = random.next(), shade = random.next(), length = random.next();
    const dvec3 root = head::trace({x, y, 9}, {0, 0, -1});
    if (browAt(root) < 0.15 + 0.7 * keep) continue;
    const double t = std::clamp((x - 1.0) / 4.0, 0.0, 1.0);
    const dvec3 n = head::normal(root);
    // Upright at the inner end, along the brow after that.
    const double lean = glm::mix(1.05, -0.30, smoothRamp(-0.1, 0.4, t)) - 0.35 * smoothRamp(0.55, 1.0, t) +
                        0.5 * (bend - 0.5);
    const dvec3 way = tangential({std::cos(lean), std::sin(lean), 0}, n);
    std::vector<dvec3> spine;
    const double reach = glm::mix(0.55, 0.8, length) * (1 - 0.25 * t);
    for (int k = 0; k < 3; ++k) {
      const double s = 0.5 * k;
      spine.push_back(head::onto(root + way * (reach * s) + dvec3(0, -0.10 * s * s, 0), 2,
                                 0.02 + 0.07 * std::sin(kPi * s)));
    }
    addRibbon(part, spine, 0.046, {root},
              glm::mix(dvec3(0.028, 0.017, 0.011), dvec3(0.085, 0.052, 0.033), shade), 0.3, kBrows);
  }
  return withMirrorImage(std::move(part));
}

FacePart lashes() {
  FacePart part;
  Random random(5);
  const auto row = [&](bool lower, int count, double longest) {
    for (int hair = 0; hair < count; ++hair) {
      const double t = (hair + 0.5 + 0.5 * (random.next() - 0.5)) / count;
      const double x = glm::mix(head::kEyeInner + 0.18, head::kEyeOuter - 0.03, t);
      const dvec2 margins = head::lidMargins(x);
      const dvec3 root = head::trace({x, lower ? margins.y - 0.01 : margins.x + 0.01, 9}, {0, 0, -1});
      const dvec3 out = glm::normalize(root - head::kEye);
      const double length = longest * (0.5 + 0.6 * smoothRamp(0.0, 0.6, t)) *
                            (1 - 0.4 * smoothRamp(0.7, 1.0, t)) * random.between(0.8, 1.1);
      const dvec3 fan = glm::normalize(
          out + dvec3(0.55 * (t - 0.42) + 0.12 * (random.next() - 0.5), lower ? -0.35 : 0.05, 0.2));
      std::vector<dvec3> spine;
      for (int k = 0; k < 3; ++k) {
        const double s = k / 2.0;
        spine.push_back(root + length * (fan * s + dvec3(0, (lower ? -0.35 : 0.75) * s * s, 0)));
      }
      addRibbon(part, spine, 0.038, {root, false, lower}, dvec3(0.012, 0.008, 0.006), 0.8, kBrows);
    }
  };
  row(false, 52, 0.33);
  row(true, 34, 0.17);
  return withMirrorImage(std::move(part));
}

FacePart hair() {
  FacePart part;
  Random random(23);
  for (int lock = 0; lock < 3800; ++lock) {
    // Even over the dome above the ears and down the nape.
    const double turn = random.between(-kPi, kPi), rise = std::asin(random.between(-0.85, 1.0));
    const double keep = random.next(), shade = random.next(), stray = random.between(-1, 1),
                 lift = random.next();
    const dvec3 from(0, 1.0, -7.5),
        out(std::sin(turn) * std::cos(rise), std::sin(rise), std::cos(turn) * std::cos(rise));
    const dvec3 root = head::trace(from + 19.0 * out, -out);
    const double thick = hairAt(root);
    if (thick < 0.1 + 0.8 * keep) continue;
    const double top = smoothRamp(3.5, 8.5, root.y), nape = smoothRamp(1.0, -5.0, root.y);
    const double length =
        glm::mix(glm::mix(1.5, 0.55, nape), 3.0, top) * (0.6 + 0.4 * thick) * (0.85 + 0.3 * lift);
    const double volume = glm::mix(0.16, 0.85, top) * (0.35 + 0.65 * thick);
    // Parted on the character's left, combed aside and back; down at the sides.
    const double part_side = smoothRamp(1.2, 3.6, root.x);
    const dvec3 combed(glm::mix(-0.85, 0.8, part_side), 0.15, -0.62), down(0.15 * root.x / 7.0, -1.0, -0.45);
    const dvec3 way = glm::mix(down, combed, top) + 0.22 * stray * dvec3(0.6, 0.2, 0.7) +
                      0.25 * dvec3(valueNoise(root * 0.55), valueNoise(root * 0.55 + dvec3(9)), 0);
    std::vector<dvec3> spine;
    dvec3 at = root;
    constexpr int kSegments = 2;
    for (int k = 0; k <= kSegments; ++k) {
      const double s = static_cast<double>(k) / kSegments;
      const double height = 0.04 + volume * (0.55 * lift + 0.45) *
                                       std::sin(0.5 * kPi * std::min(1.0, 1.6 * s)) * (1 - 0.35 * s);
      spine.push_back(head::onto(at, 2, height));
      at += tangential(way, head::normal(spine.back())) * (length / kSegments);
    }
    const dvec3 dark(0.030, 0.018, 0.011), light(0.110, 0.064, 0.036);
    addRibbon(part, spine, glm::mix(0.15, 0.24, top), {root}, glm::mix(dark, light, shade * shade),
              0.35 * stray, kHairs);
  }
  return part;
}

}  // namespace furrow::content

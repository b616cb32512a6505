#include "content/expressions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>

#include "content/head.h"
#include "content/surface_mesh.h"

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

// A soft spot: 1 at (x, y), falling with the radii.
double spot(dvec3 p, dvec2 centre, dvec2 radii) {
  const dvec2 q = (dvec2(p) - centre) / radii;
  return std::exp(-glm::dot(q, q));
}

dvec3 turnAboutX(dvec3 p, dvec3 centre, double angle) {
  const dvec3 q = p - centre;
  const double c = std::cos(angle), s = std::sin(angle);
  return centre + dvec3(q.x, c * q.y + s * q.z, c * q.z - s * q.y);
}

double front(dvec3 p) {
  return smoothRamp(-5.5, -2.5, p.z);
}

// The lids turn on the eyeball. `upper` and `lower` say how far each margin goes towards the line where they
// meet.
dvec3 closeLids(const HeadPoint& point, double upper, double lower) {
  const dvec3 p = point.position;
  if (p.x <= head::kEyeInner || p.x >= head::kEyeOuter || std::abs(p.y) > 2 || p.z < head::kEye.z)
    return dvec3(0);
  const dvec2 margins = head::lidMargins(p.x);
  const auto elevation = [&](double y) {
    const dvec3 margin = head::trace({p.x, y, 8}, {0, 0, -1});
    return std::atan2(y - head::kEye.y, margin.z - head::kEye.z);
  };
  const double top = elevation(margins.x), bottom = elevation(margins.y), meet = glm::mix(bottom, top, 0.16);
  // Skin slides under the fold of the lid, which lies close to the margin at the corners.
  const double t = (p.x - head::kEyeInner) / (head::kEyeOuter - head::kEyeInner);
  const double fold = 0.12 + 0.62 * std::pow(std::sin(glm::pi<double>() * t), 0.7);
  const double angle = point.lower_lid
                           ? lower * (meet - bottom) * smoothRamp(margins.y - 1.2 * fold, margins.y, p.y)
                           : upper * (meet - top) * smoothRamp(margins.x + fold, margins.x, p.y);
  return turnAboutX(p + point.offset, head::kEye, angle) - (p + point.offset);
}

double aboveLids(dvec3 p) {
  return smoothRamp(0.95, 1.7, p.y);
}

// Up from the brow, nothing at the hairline: the forehead between them is squeezed.
double forehead(double y) {
  return smoothRamp(0.9, 2.0, y) * smoothRamp(6.3, 2.0, y);
}

dvec3 browInnerUp(const HeadPoint& point) {
  const dvec3 p = point.position;
  return dvec3(0.0, 1.10, 0.0) * forehead(p.y) * std::exp(-std::pow(p.x / 3.3, 4)) * front(p) +
         dvec3(0, 0, -0.28) * forehead(p.y) * std::exp(-std::pow(p.x / 3.3, 4));
}

dvec3 browOuterUp(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double w = forehead(p.y) * std::exp(-std::pow((p.x - 4.2) / 2.3, 2)) * front(p);
  return dvec3(0.0, 0.95, -0.25) * w;
}

dvec3 browDown(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double w = spot(p, {2.0, 1.9}, {2.1, 1.5}) * smoothRamp(0.55, 1.6, p.y) * front(p);
  const double together = smoothRamp(0.0, 1.4, p.x);
  return dvec3(-0.72 * together, -0.62 * smoothRamp(-0.6, 0.8, p.x), 0.16) * w;
}

dvec3 eyeWide(const HeadPoint& point) {
  const dvec3 p = point.position;
  return closeLids(point, -0.30, -0.12) + dvec3(0, 0.14, 0) * spot(p, {3.2, 1.7}, {2.2, 0.9}) * aboveLids(p);
}

dvec3 eyeBlink(const HeadPoint& point) {
  return closeLids(point, 1.0, 1.0);
}

// The skin beside the outer corner of the eye is gathered to the corner's height.
dvec3 gatheredTemple(dvec3 p) {
  const double temple = spot(p, {5.7, 0.0}, {1.2, 2.6}) *
                        smoothRamp(head::kEyeOuter - 0.1, head::kEyeOuter + 0.9, p.x) * front(p);
  return dvec3(-0.22, -0.46 * p.y * std::exp(-std::pow(p.y / 2.3, 2)), 0.12) * temple;
}

// Orbicularis oculi: the lids narrow.
dvec3 eyeSquint(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double lids = smoothRamp(0.9, 1.5, std::abs(p.y));
  const double cheek = spot(p, {3.9, -1.9}, {1.7, 0.9}) * smoothRamp(-0.85, -1.5, p.y);
  const double brow = spot(p, {3.9, 1.9}, {1.8, 0.8}) * lids * aboveLids(p);
  return closeLids(point, 0.24, 1.5) + gatheredTemple(p) + dvec3(0.0, 0.36, 0.12) * cheek +
         dvec3(0, -0.22, 0.05) * brow;
}

dvec3 cheekSquint(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double w = spot(p, {3.8, -2.6}, {1.7, 1.25}) * smoothRamp(-0.75, -1.6, p.y) * front(p);
  return dvec3(0.05, 0.62, 0.22) * w + 0.5 * gatheredTemple(p) + closeLids(point, 0.0, 0.7);
}

double side(double x) {
  return smoothRamp(-1.3, 1.3, x);
}

// The corner goes out and up, the lip is drawn under the nasolabial fold, behind which the cheek piles up.
dvec3 mouthSmile(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double left = side(p.x) * front(p);
  const head::Fold fold = head::nasolabialFold(p);
  const double lips = spot(p, {2.5, -7.0}, {1.9, 1.25}) * left;
  const double held = smoothRamp(0.9, 0.0, fold.distance);
  const double beside = smoothRamp(-3.4, -4.8, p.y) * smoothRamp(-8.0, -6.6, p.y) * left;
  const double lip_side = smoothRamp(-2.2, -0.7, fold.distance) * smoothRamp(0.5, -0.6, fold.distance) *
                          smoothRamp(-7.2, -5.6, p.y);
  const double cheek = spot(p, {4.0, -4.2}, {1.7, 1.9}) * left * smoothRamp(-0.8, -2.0, p.y) *
                       smoothRamp(-0.15, 0.65, fold.distance);
  const double crease = std::exp(-std::pow(fold.distance / 0.32, 2)) * beside;
  return dvec3(0.70, 0.54, -0.38) * lips * (0.25 + 0.75 * held) +
         dvec3(0.24 * fold.across, 0) * lip_side * beside + dvec3(0.02, 0.36, 0.50) * cheek +
         dvec3(0.02, 0.03, -0.13) * crease;
}

// How much of a pull at one corner of the mouth a point feels.
double corner(dvec3 p) {
  return spot(p, {2.5, -7.0}, {1.7, 1.3}) * side(p.x) * front(p);
}

// Lips that part stay together at the corner.
double beforeCorner(dvec3 p) {
  return smoothRamp(head::kMouth, 0.45 * head::kMouth, std::abs(p.x));
}

dvec3 mouthFrown(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double below = spot(p, {2.6, -8.3}, {1.5, 1.0}) * side(p.x) * front(p);
  return dvec3(-0.04, -0.62, -0.12) * corner(p) + dvec3(0.06, -0.18, 0.12) * below;
}

dvec3 mouthStretch(const HeadPoint& point) {
  const dvec3 p = point.position;
  // Platysma draws the skin of the neck up and stands out of it in cords, to which the skin between them
  // goes.
  const double neck = smoothRamp(-10.4, -11.9, p.y + 0.3 * p.z + 0.9) * smoothRamp(-15.2, -14.0, p.y) *
                      smoothRamp(-9.5, -7.0, p.z);
  dvec3 cords(0);
  for (const double cord : {1.6, 3.7}) {
    const double beside = p.x - cord, near = std::exp(-std::pow(beside / 0.85, 2));
    cords += dvec3(-0.55 * beside * near, 0, 0) +
             0.34 * std::exp(-std::pow(beside / 0.45, 2)) * glm::normalize(dvec3(p.x, 0, p.z + 8.3));
  }
  return dvec3(0.62, -0.22, -0.45) * corner(p) + (dvec3(0.0, 0.20, 0.0) * side(p.x) + cords) * neck;
}

// About the middle of the mouth, with the lips parted by `apart`.
dvec3 purse(const HeadPoint& point, double narrow, double forward, double apart) {
  const dvec3 p = point.position;
  const double up = p.y - head::lipLine(0.0);
  const double about = std::exp(-std::pow(p.x / 3.6, 4) - std::pow(up / 2.4, 2)) * front(p);
  const double lips = std::exp(-std::pow(p.x / 1.9, 2) - std::pow(up / 1.15, 2)) * front(p);
  const double open = apart * std::exp(-std::pow(p.x / 2.15, 4) - std::pow(up / 1.6, 2)) * front(p);
  return dvec3(-narrow * p.x * about, -0.10 * up * about + (point.lower_lip ? -open : 0.8 * open),
               forward * lips);
}

dvec3 mouthPucker(const HeadPoint& point) {
  return purse(point, 0.36, 0.75, 0.0);
}

dvec3 mouthFunnel(const HeadPoint& point) {
  return purse(point, 0.36, 0.66, 0.72);
}

dvec3 mouthUpperUp(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double lip = spot(p, {0.9, -6.4}, {1.6, 1.15}) * side(p.x) * (point.lower_lip ? 0.0 : 1.0) *
                     beforeCorner(p) * front(p);
  const head::Fold fold = head::nasolabialFold(p);
  const double cheek = spot(p, {3.0, -4.6}, {1.2, 1.2}) * side(p.x) * smoothRamp(-0.2, 0.7, fold.distance);
  return dvec3(0.05, 0.46, 0.06) * lip + dvec3(0.0, 0.20, 0.18) * cheek * front(p);
}

dvec3 mouthLowerDown(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double lip = spot(p, {0.9, -7.7}, {1.6, 1.1}) * side(p.x) * (point.lower_lip ? 1.0 : 0.0) *
                     beforeCorner(p) * front(p);
  return dvec3(0.04, -0.52, 0.04) * lip;
}

// The pad of the chin is pushed up and lifts both lips.
dvec3 mouthShrug(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double pad = spot(p, {0.0, -9.7}, {2.1, 1.25}) * front(p),
               lips = spot(p, {0.0, -7.1}, {2.4, 1.1}) * front(p);
  return dvec3(0.0, 0.52, 0.14) * pad + dvec3(0.0, 0.14, 0.12) * lips;
}

dvec3 cheekPuff(const HeadPoint& point) {
  const dvec3 p(std::abs(point.position.x), point.position.y, point.position.z);
  const double cheek =
      spot(p, {4.1, -6.2}, {2.0, 2.2}) * smoothRamp(-7.0, -3.0, p.z) * smoothRamp(1.6, 3.2, p.x);
  return dvec3(0.55 * (point.position.x < 0 ? -1.0 : 1.0), 0.0, 0.45) * cheek;
}

dvec3 noseSneer(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double wing = spot(p, {1.35, -3.7}, {1.0, 1.5}) * side(p.x * 1.6);
  const double lip = spot(p, {1.6, -5.7}, {1.1, 1.1}) * side(p.x) * (point.lower_lip ? 0.0 : 1.0);
  const double flank = spot(p, {1.1, -1.9}, {1.0, 1.3}) * side(p.x * 1.6) * smoothRamp(0.6, -0.6, p.y);
  const double front_face = smoothRamp(-1.0, 0.5, p.z);
  return (dvec3(0.14, 0.60, -0.08) * wing + dvec3(0.05, 0.42, 0.05) * lip + dvec3(0.03, 0.48, 0.08) * flank) *
         front_face;
}

// The jaw turns about its hinge before the ear; the corner of the mouth follows by less than half and is
// drawn in, so that the cheek is stretched.
dvec3 jawOpen(const HeadPoint& point) {
  const dvec3 p = point.position;
  const double beyond = std::max(0.0, std::abs(p.x) / head::kMouth - 1.0);
  const double u = std::min(std::abs(p.x) / head::kMouth, 1.0);
  const double above = p.y - head::lipLine(std::min(std::abs(p.x), head::kMouth));
  const double length = 1.25 + 1.6 * beyond;
  const double corner = std::pow(u, 2.5) * std::exp(-above * above / (length * length));
  const double follow = point.bone        ? (point.lower_lip ? 1.0 : 0.0)
                        : point.lower_lip ? 1.0 - 0.58 * corner
                                          : 0.42 * corner;
  const double fade = smoothRamp(-16.0, -10.8, p.y + 0.45 * std::min(p.z, 0.0)) * smoothRamp(-9.0, -5.0, p.z);
  const dvec3 m(std::abs(p.x), p.y, p.z);
  const double drawn_in = point.bone ? 0.0 : spot(m, {2.2, -7.1}, {1.25, 2.2}) * front(p);
  return turnAboutX(p, {0, -2.6, -6.8}, -glm::radians(13.0) * follow * fade) - p -
         dvec3(0.20 * p.x, 0, 0) * drawn_in;
}

struct Expression {
  std::string_view name;
  dvec3 (*move)(const HeadPoint&);
  int side;  // +1 left, -1 right (mirrored), 0 both at once
};

constexpr std::array kExpressions = {
    Expression{"browInnerUp", browInnerUp, 0},
    Expression{"browDownLeft", browDown, 1},
    Expression{"browDownRight", browDown, -1},
    Expression{"browOuterUpLeft", browOuterUp, 1},
    Expression{"browOuterUpRight", browOuterUp, -1},
    Expression{"eyeBlinkLeft", eyeBlink, 1},
    Expression{"eyeBlinkRight", eyeBlink, -1},
    Expression{"eyeSquintLeft", eyeSquint, 1},
    Expression{"eyeSquintRight", eyeSquint, -1},
    Expression{"cheekSquintLeft", cheekSquint, 1},
    Expression{"cheekSquintRight", cheekSquint, -1},
    Expression{"noseSneerLeft", noseSneer, 1},
    Expression{"noseSneerRight", noseSneer, -1},
    Expression{"mouthSmileLeft", mouthSmile, 1},
    Expression{"mouthSmileRight", mouthSmile, -1},
    Expression{"jawOpen", jawOpen, 0},
    Expression{"eyeWideLeft", eyeWide, 1},
    Expression{"eyeWideRight", eyeWide, -1},
    Expression{"mouthFrownLeft", mouthFrown, 1},
    Expression{"mouthFrownRight", mouthFrown, -1},
    Expression{"mouthStretchLeft", mouthStretch, 1},
    Expression{"mouthStretchRight", mouthStretch, -1},
    Expression{"mouthUpperUpLeft", mouthUpperUp, 1},
    Expression{"mouthUpperUpRight", mouthUpperUp, -1},
    Expression{"mouthLowerDownLeft", mouthLowerDown, 1},
    Expression{"mouthLowerDownRight", mouthLowerDown, -1},
    Expression{"mouthPucker", mouthPucker, 0},
    Expression{"mouthFunnel", mouthFunnel, 0},
    Expression{"mouthShrugLower", mouthShrug, 0},
    Expression{"cheekPuff", cheekPuff, 0},
};

constexpr auto kNames = [] {
  std::array<std::string_view, kExpressions.size()> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kExpressions[i].name;
  return names;
}();

}  // namespace

std::span<const std::string_view> expressionNames() {
  return kNames;
}

dvec3 displacement(size_t index, const HeadPoint& point) {
  const Expression& expression = kExpressions[index];
  if (point.bone && expression.move != jawOpen) return dvec3(0);
  HeadPoint at = point;
  if (expression.side < 0) {
    at.position.x = -at.position.x;
    at.offset.x = -at.offset.x;
  }
  dvec3 moved = expression.move(at);
  if (expression.side < 0) moved.x = -moved.x;
  return moved;
}

}  // namespace furrow::content

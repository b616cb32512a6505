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

using glm::dvec3;

constexpr double kPi = glm::pi<double>();
constexpr double kIrisAngle = 0.455, kPupilAngle = 0.155;
constexpr uint32_t kSpokes = 48, kRings = 22, kCornea = 14;

// The angle from the axis; more rings lie within the cornea.
double ringAngle(double ring) {
  return ring <= kCornea ? 0.55 * ring / kCornea : glm::mix(0.55, kPi, (ring - kCornea) / (kRings - kCornea));
}

// Colour at the angle `a` from the axis, `b` about it.
dvec3 eyeColor(double a, double b) {
  const dvec3 spoke(std::cos(b), std::sin(b), 0);
  if (a < kIrisAngle + 0.06) {
    const double t = (a - kPupilAngle) / (kIrisAngle - kPupilAngle);
    const double fibre = valueNoise(spoke * 9.0 + dvec3(0, 0, 2.2 * t)) + 0.6 * valueNoise(spoke * 19.0);
    dvec3 iris = glm::mix(dvec3(0.15, 0.125, 0.075), dvec3(0.10, 0.17, 0.19), smoothRamp(0.1, 0.65, t));
    iris *= 1.0 + 0.42 * fibre;
    iris *= glm::mix(1.0, 0.16, smoothRamp(0.72, 1.0, t));  // limbus
    iris *= 0.85;
    iris = glm::mix(dvec3(0.004), iris, smoothRamp(-0.03, 0.06, t));  // pupil
    return glm::mix(iris, dvec3(0.56, 0.50, 0.47), smoothRamp(0.97, 1.16, t));
  }
  // The white is whitest beside the iris, and reddens towards the corners.
  const double side = smoothRamp(0.55, 1.15, a) * std::abs(spoke.x);
  const double veins = std::max(0.0, valueNoise(dvec3(spoke.x * 3, spoke.y * 14, a * 4))) * side;
  return glm::mix(dvec3(0.58, 0.53, 0.50), dvec3(0.44, 0.27, 0.24), 0.55 * side + 0.5 * veins);
}

}  // namespace

Mesh eyeball() {
  // The cornea stands out of the ball.
  const auto at = [](double a, double b) {
    const double bulge = 1 + 0.075 * std::pow(smoothRamp(0.54, 0.0, a), 0.8);
    return 0.01 * head::kEyeball * bulge *
           dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
  };
  Mesh mesh;
  mesh.name = "Eye";
  Primitive& primitive = mesh.primitives.emplace_back();
  primitive.material = kEye;
  for (uint32_t ring = 0; ring <= kRings; ++ring) {
    const bool pole = ring == 0 || ring == kRings;  // a vertex a triangle there
    for (uint32_t spoke = 0; spoke <= kSpokes - pole; ++spoke) {
      const double a = ringAngle(ring), b = 2 * kPi * (spoke % kSpokes) / kSpokes;
      const dvec3 p = ring == 0        ? dvec3(0, 0, at(0, 0).z)
                      : ring == kRings ? dvec3(0, 0, -0.01 * head::kEyeball)
                                       : at(a, b);
      constexpr double e = 1e-4;
      const dvec3 n =
          pole ? dvec3(0, 0, ring == 0 ? 1 : -1)
               : glm::normalize(glm::cross(at(a + e, b) - at(a - e, b), at(a, b + e) - at(a, b - e)));
      primitive.positions.emplace_back(p);
      primitive.normals.emplace_back(n);
      primitive.uvs.emplace_back((spoke + 0.5 * pole) / kSpokes, static_cast<double>(ring) / kRings);
      // The upper lid and its lashes keep the light off.
      const double lit = glm::mix(1.0, 0.45, smoothRamp(0.0, 0.45, std::sin(a) * std::sin(b)));
      primitive.colors.emplace_back(glm::vec3(static_cast<float>(lit)), 1.0f);
    }
  }
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const uint32_t b = kSpokes + ring * (kSpokes + 1) + spoke, a = ring == 0 ? spoke : b - kSpokes - 1;
      if (ring + 1 < kRings) primitive.indices.insert(primitive.indices.end(), {a, b, b + 1});
      if (ring > 0)
        primitive.indices.insert(primitive.indices.end(), {a, ring + 1 < kRings ? b + 1 : b, a + 1});
    }
  }
  return mesh;
}

Image eyeColors() {
  Image image{512, 512, {}};
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = 0; x < image.width; ++x) {
      const double a = ringAngle((y + 0.5) / image.height * kRings), b = 2 * kPi * (x + 0.5) / image.width;
      for (const uint8_t byte : srgb(eyeColor(a, b))) image.rgb.push_back(byte);
    }
  return image;
}

}  // namespace furrow::content

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/constants.hpp>

#include "content/face_parts.h"
#include "content/head.h"

// Two rows of teeth in their gums, and the tongue between them.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();
// Of the material's.
constexpr dvec3 kEnamel(1.0, 0.90, 0.77), kGum(0.52, 0.18, 0.17), kTongue(0.47, 0.17, 0.15);

// Columns and rows of points, `from` on; quads that face out are counter-clockwise.
void addGrid(FacePart& part, uint32_t from, uint32_t columns, uint32_t rows, bool turned) {
  for (uint32_t j = 0; j + 1 < rows; ++j)
    for (uint32_t i = 0; i + 1 < columns; ++i) {
      const uint32_t a = from + j * columns + i, b = a + columns;
      if (turned)
        part.mesh.addQuad(a, b, b + 1, a + 1);
      else
        part.mesh.addQuad(a, a + 1, b + 1, b);
    }
}

void addPoint(FacePart& part, dvec3 position, dvec3 color, dvec2 uv, bool lower) {
  part.mesh.addVertex(part.addPoint(position, lower, lower), uv);
  part.colors.push_back(color);
}

// The dental arch seen from above: x and z so far along it from its middle.
dvec2 archAt(double length) {
  constexpr double kWide = 2.25, kDeep = 1.9, kStep = 0.01;
  double angle = 0;
  for (double gone = 0; gone < std::abs(length);
       gone += kStep * std::hypot(kWide * std::cos(angle), kDeep * std::sin(angle)))
    angle += kStep;
  return {std::copysign(kWide * std::sin(angle), length), 2.32 - kDeep * (1 - std::cos(angle))};
}

void addRow(FacePart& part, bool lower) {
  // Widths from the middle outwards: incisors, canine, premolars.
  constexpr std::array<double, 5> kUpper{0.84, 0.66, 0.74, 0.66, 0.62}, kLower{0.52, 0.58, 0.66, 0.66, 0.66};
  constexpr std::array<double, 4> kAcross{-0.5, -0.4, 0.0, 0.4};  // of a tooth's width from its middle
  constexpr std::array<double, 6> kDown{0.0, 0.10, 0.45,
                                        0.9, 1.0,  1.6};  // of its height from its edge; then gum
  struct Column {
    double at, across;  // along the arch; of the tooth's width, [-0.5, 0.5]
    size_t tooth;
  };
  std::vector<Column> columns;
  const auto& widths = lower ? kLower : kUpper;
  for (int side : {-1, 1})
    for (size_t k = 0; k < widths.size(); ++k) {
      const size_t tooth = side < 0 ? widths.size() - 1 - k : k;
      double before = 0;
      for (size_t n = 0; n < tooth; ++n) before += widths[n];
      for (double across : kAcross)
        columns.push_back({side * (before + 0.5 * widths[tooth]) + across * widths[tooth], across, tooth});
    }
  columns.push_back({-columns.front().at, 0.5, widths.size() - 1});

  const uint32_t first = static_cast<uint32_t>(part.mesh.vertices.size());
  for (size_t j = 0; j < kDown.size(); ++j)
    for (size_t i = 0; i < columns.size(); ++i) {
      const auto [at, across, tooth] = columns[i];
      const double v = kDown[j], middle = 1 - 4 * across * across;
      const bool gum = j + 2 >= kDown.size();
      // Edges are round at their corners, gums reach further down between the teeth.
      const double height = (lower ? 0.72 : 0.86) + (tooth == 2 ? 0.06 : 0.0) - (tooth == 1 ? 0.05 : 0.0);
      const double rounded = 0.07 * std::pow(1 - middle, 2) * (1 - std::min(1.0, 2 * v));
      const double neck = v >= 0.9 ? -0.10 * (1 - middle) : 0.0;
      const double y = v * height + rounded + neck;
      const double thick =
          gum ? 0.0 : 0.10 * std::pow(std::max(middle, 0.0), 0.4) + 0.05 * std::sin(kPi * std::min(v, 1.0));
      const dvec2 arch = archAt(at);
      const dvec3 out = glm::normalize(dvec3(arch.x / 1.6, 0, 1.2));
      const double edge = lower ? -7.03 : -7.27;
      const dvec3 p = dvec3(arch.x, edge + (lower ? -y : y), arch.y - (lower ? 0.2 : 0.0)) + out * thick;
      // The cheeks keep the light off of what lies behind the corners of the mouth.
      const double shade = glm::mix(1.0, 0.30, smoothRamp(1.0, 3.4, std::abs(at)));
      const double gap = gum || v < 0.05 ? 1.0 : glm::mix(0.78, 1.0, std::min(1.0, 3 * middle));
      const dvec3 color =
          (gum ? kGum : glm::mix(kEnamel, kEnamel * dvec3(1.0, 0.93, 0.84), smoothRamp(0.4, 1.0, v))) * gap *
          shade;
      addPoint(part, p, color,
               {0.02 + 0.96 * static_cast<double>(i) / static_cast<double>(columns.size() - 1),
                (lower ? 0.3 : 0.05) + 0.13 * v},
               lower);
    }
  addGrid(part, first, static_cast<uint32_t>(columns.size()), static_cast<uint32_t>(kDown.size()), lower);
}

// Its back, from the tip to where the throat is dark, with the furrow along its middle.
void addTongue(FacePart& part) {
  constexpr uint32_t kAcross = 13, kAlong = 9;
  const uint32_t first = static_cast<uint32_t>(part.mesh.vertices.size());
  for (uint32_t j = 0; j < kAlong; ++j)
    for (uint32_t i = 0; i < kAcross; ++i) {
      const double u = 2.0 * i / (kAcross - 1) - 1, v = static_cast<double>(j) / (kAlong - 1);
      const double across = 0.5 * kPi * u, along = glm::mix(1.5, -0.9, v);  // angles
      const double wide = 1.45 * std::sqrt(std::max(std::cos(along), 0.03));
      const dvec3 p(
          wide * std::sin(across),
          -7.28 + 0.48 * std::cos(across) * std::cos(0.8 * along) - 0.07 * std::exp(-40 * u * u) * (1 - v),
          0.35 + 1.65 * std::sin(along));
      addPoint(part, p, kTongue * glm::mix(1.0, 0.25, v) * glm::mix(0.75, 1.0, std::cos(across)),
               {0.02 + 0.46 * (u + 1), 0.6 + 0.38 * v}, true);
    }
  addGrid(part, first, kAcross, kAlong, false);
}

}  // namespace

FacePart teeth() {
  FacePart part;
  addRow(part, false);
  addRow(part, true);
  addTongue(part);
  part.materials.assign(part.mesh.triangles.size(), kTeeth);
  for (HeadPoint& point : part.points) point.bone = true;
  return part;
}

}  // namespace furrow::content

#pragma once

// What every morph target does to a point of the head. Centimetres, head space (content/head.h).

#include <glm/vec3.hpp>
#include <span>
#include <string_view>

namespace furrow::content {

// A point of the head at rest. A point of the lips or of the pocket behind them belongs to one of the two
// lips, wherever it lies.
struct HeadPoint {
  glm::dvec3 position;
  bool lower_lip = false;
  bool lower_lid = false;
  bool bone = false;     // goes with the jaw alone, if it is lower_lip
  glm::dvec3 offset{0};  // of a hair: from its root, `position`, which alone decides how far it goes
};

// Names in ARKit's spelling; Left is the character's own.
std::span<const std::string_view> expressionNames();

// Displacement of a point under expression `index` at weight 1.
glm::dvec3 displacement(size_t index, const HeadPoint& point);

}  // namespace furrow::content

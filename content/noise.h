#pragma once

// Numbers that look like chance and are the same everywhere.

#include <cstdint>
#include <glm/vec3.hpp>

namespace furrow::content {

// [0, 1), by the last counter of splitmix64.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double next();
  double between(double low, double high) { return low + (high - low) * next(); }

 private:
  uint64_t state_;
};

// Smooth, about [-1, 1], features one unit wide.
double valueNoise(glm::dvec3 p);

// Of points strewn one to a unit cell, the distances of the two nearest [Worley 1996].
struct Cells {
  double nearest, second;
};
Cells cells(glm::dvec3 p);

}  // namespace furrow::content

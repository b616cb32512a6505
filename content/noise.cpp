#include "content/noise.h"

#include <cmath>
#include <glm/common.hpp>

namespace furrow::content {
namespace {

uint64_t mixed(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double unit(uint64_t bits) {
  return static_cast<double>(bits >> 11) / 9007199254740992.0;
}

}  // namespace

double Random::next() {
  state_ += 0x9e3779b97f4a7c15u;
  return unit(mixed(state_));
}

double valueNoise(glm::dvec3 p) {
  const glm::dvec3 cell = glm::floor(p), t = p - cell, s = t * t * (3.0 - 2.0 * t);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    uint64_t key = 0;
    double weight = 1;
    for (int k = 0; k < 3; ++k) {
      const int step = corner >> k & 1;
      key = mixed(key * 31 + static_cast<uint64_t>(static_cast<int64_t>(cell[k]) + step + 4096));
      weight *= step ? s[k] : 1 - s[k];
    }
    sum += weight * (2 * unit(key) - 1);
  }
  return sum;
}

}  // namespace furrow::content

#include "content/noise.h"

#include <algorithm>
#include <array>
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
  const auto step = [&](uint64_t key, int axis, int by) {
    return mixed(key * 31 + static_cast<uint64_t>(static_cast<int64_t>(cell[axis]) + by + 4096));
  };
  const auto along = [&](int axis, double before, double after) {
    return before + s[axis] * (after - before);
  };
  std::array<double, 2> x, y, z;
  for (int i = 0; i < 2; ++i) {
    const uint64_t column = step(0, 0, i);
    for (int j = 0; j < 2; ++j) {
      const uint64_t row = step(column, 1, j);
      for (int k = 0; k < 2; ++k) z[k] = unit(step(row, 2, k));
      y[j] = along(2, z[0], z[1]);
    }
    x[i] = along(1, y[0], y[1]);
  }
  return 2 * along(0, x[0], x[1]) - 1;
}

Cells cells(glm::dvec3 p) {
  const glm::dvec3 cell = glm::floor(p), in = p - cell;
  // How far the cell before, this one and the next one are, along each axis.
  const std::array<glm::dvec3, 3> away{in, glm::dvec3(0), 1.0 - in};
  double nearest = 1e9, second = 1e9;
  constexpr std::array kOrder{0, -1, 1};
  for (int x : kOrder)
    for (int y : kOrder)
      for (int z : kOrder) {
        const glm::dvec3 least(away[x + 1].x, away[y + 1].y, away[z + 1].z);
        if (least.x * least.x + least.y * least.y + least.z * least.z >= second) continue;
        const glm::dvec3 there = cell + glm::dvec3(x, y, z);
        uint64_t key = 0;
        for (int axis = 0; axis < 3; ++axis)
          key = key * 0x9e3779b97f4a7c15u + static_cast<uint64_t>(static_cast<int64_t>(there[axis]) + 4096);
        const uint64_t bits = mixed(key);
        const glm::dvec3 to =
            there + glm::dvec3(bits & 0xfffff, bits >> 20 & 0xfffff, bits >> 40 & 0xfffff) / 1048576.0 - p;
        const double squared = to.x * to.x + to.y * to.y + to.z * to.z;
        second = std::min(second, std::max(nearest, squared));
        nearest = std::min(nearest, squared);
      }
  return {std::sqrt(nearest), std::sqrt(second)};
}

}  // namespace furrow::content

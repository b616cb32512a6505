#pragma once

// Cells of a grid that a search within a reach must look at: shared by the binding (bind.cpp) and the weld
// (pipeline/bake/places.cpp).

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace furrow {

inline uint64_t hashOfThree(uint64_t x, uint64_t y, uint64_t z) {
  uint64_t h = (x ^ std::rotl(y, 32)) * 0x9e3779b97f4a7c15u;
  h = (h ^ (h >> 32) ^ z) * 0xd6e8feb86659fd93u;
  return h ^ (h >> 32);
}

class NearCells {
 public:
  // `edge` of a cell, at least twice `reach`, which is more than 0.
  NearCells(double reach, double edge) : reach_(reach), inverse_edge_(1.0 / edge) {}

  struct Hashes {
    std::array<uint64_t, 8> cells;  // of the position's own cell first
    uint32_t count;
  };

  // Hashes of all cells that hold anything within reach: one, or where the ball's box crosses a border of
  // cells up to eight.
  Hashes around(double x, double y, double z) const {
    const double p[3] = {x, y, z};
    uint64_t own[3], other[3];  // an axis: its cell, the neighbour that the box touches
    for (int axis = 0; axis < 3; ++axis) {
      own[axis] = cellOf(p[axis]);
      const uint64_t low = cellOf(p[axis] - reach_);
      other[axis] = low != own[axis] ? low : cellOf(p[axis] + reach_);
    }
    Hashes hashes;
    hashes.cells[0] = hashOfThree(own[0], own[1], own[2]);
    hashes.count = 1;
    const int touched = (other[0] != own[0]) | (other[1] != own[1]) << 1 | (other[2] != own[2]) << 2;
    for (int side = touched; side != 0; side = (side - 1) & touched)  // every subset of the touched axes
      hashes.cells[hashes.count++] = hashOfThree(side & 1 ? other[0] : own[0], side & 2 ? other[1] : own[1],
                                                 side & 4 ? other[2] : own[2]);
    return hashes;
  }

 private:
  // The number of the cell around x, rounded by what adding 3 * 2^51 leaves of the fraction: it ascends with
  // x, which is all that is asked of it.
  uint64_t cellOf(double x) const {
    return std::bit_cast<uint64_t>(std::clamp(x * inverse_edge_, -0x1p51, 0x1p51) + 0x1.8p52);
  }

  double reach_, inverse_edge_;
};

}  // namespace furrow

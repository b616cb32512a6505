#pragma once

// How far two pictures are apart.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/maps/image.h"

namespace furrow::test {

// In steps of 1/255 of the colours: over the picture, and in the worst of its square blocks. Drivers round
// differently and differ in single pixels at edges.
struct Difference {
  double mean = 0.0, worst_block = 0.0;
};

// `block`: side of the blocks in pixels, which the pictures' sides are multiples of. Pictures of different
// sizes fail the test.
inline Difference difference(const pipeline::Image& a, const pipeline::Image& b, uint32_t block) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  Difference result;
  if (a.width != b.width || a.height != b.height) return {1e9, 1e9};
  for (uint32_t y = 0; y + block <= a.height; y += block)
    for (uint32_t x = 0; x + block <= a.width; x += block) {
      double sum = 0.0;
      for (uint32_t i = 0; i < block * block; ++i)
        for (int c = 0; c < 3; ++c)
          sum += std::abs(a.at(x + i % block, y + i / block)[c] - b.at(x + i % block, y + i / block)[c]);
      const double mean = sum * 255.0 / (3 * block * block);
      result.worst_block = std::max(result.worst_block, mean);
      result.mean += mean * block * block / (a.width * a.height);
    }
  return result;
}

}  // namespace furrow::test

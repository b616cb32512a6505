#pragma once

// Where texels are, and those of the block formats (Direct3D 11, "BC1 format" and "BC4 format"): blocks of 4
// x 4, rows of blocks one behind the other.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "furrow/asset.h"

namespace furrow {

// std::floor is a call where the baseline has no instruction for it.
inline float floorOf(float x) {
  if (!(std::abs(x) < 8388608.0f)) return x;
  const auto whole = static_cast<float>(static_cast<int32_t>(x));
  return whole > x ? whole - 1.0f : whole;
}

inline float wrapTo(Wrap wrap, float at) {
  if (wrap == Wrap::kClamp) return std::clamp(at, 0.0f, 1.0f);
  if (wrap == Wrap::kRepeat) return at - floorOf(at);
  const float turned = at - 2.0f * floorOf(0.5f * at);
  return turned > 1.0f ? 2.0f - turned : turned;
}

// The eight bytes at `offset` of the block, of `block_bytes`, that holds x, y of a slice `width` texels wide.
inline uint64_t blockAt(const std::byte* slice, uint32_t width, uint32_t x, uint32_t y, size_t block_bytes,
                        size_t offset) {
  uint64_t block;
  std::memcpy(&block, slice + (size_t{y / 4} * ((width + 3) / 4) + x / 4) * block_bytes + offset,
              sizeof block);
  return block;
}

// Two ends, then three bits a texel.
inline float bc4Texel(uint64_t block, uint32_t x, uint32_t y) {
  const auto end0 = static_cast<int32_t>(block & 255), end1 = static_cast<int32_t>(block >> 8 & 255);
  const auto code = static_cast<int32_t>(block >> (16 + 3 * (4 * (y % 4) + x % 4)) & 7);
  if (code < 2) return static_cast<float>(code == 0 ? end0 : end1) * (1.0f / 255.0f);
  if (end0 > end1)
    return static_cast<float>((8 - code) * end0 + (code - 1) * end1) * (1.0f / (7.0f * 255.0f));
  if (code >= 6) return code == 6 ? 0.0f : 1.0f;
  return static_cast<float>((6 - code) * end0 + (code - 1) * end1) * (1.0f / (5.0f * 255.0f));
}

// Two colours of 5, 6 and 5 bits, then two bits a texel. BC3's never has but four colours.
inline Float3 bc1Texel(uint64_t block, uint32_t x, uint32_t y, bool always_four) {
  const auto end0 = static_cast<uint32_t>(block & 0xffff), end1 = static_cast<uint32_t>(block >> 16 & 0xffff);
  const auto code = static_cast<uint32_t>(block >> (32 + 2 * (4 * (y % 4) + x % 4)) & 3);
  const auto color = [](uint32_t c) {
    return Float3{static_cast<float>(c >> 11) * (1.0f / 31.0f),
                  static_cast<float>(c >> 5 & 63) * (1.0f / 63.0f),
                  static_cast<float>(c & 31) * (1.0f / 31.0f)};
  };
  if (code == 0) return color(end0);
  if (code == 1) return color(end1);
  const Float3 a = color(end0), b = color(end1);
  const auto mix = [&](float of_a, float of_b) {
    return Float3{a.x * of_a + b.x * of_b, a.y * of_a + b.y * of_b, a.z * of_a + b.z * of_b};
  };
  if (always_four || end0 > end1)
    return code == 2 ? mix(2.0f / 3.0f, 1.0f / 3.0f) : mix(1.0f / 3.0f, 2.0f / 3.0f);
  return code == 2 ? mix(0.5f, 0.5f) : Float3{0.0f, 0.0f, 0.0f};
}

}  // namespace furrow

#pragma once

// A layer's directions as the file holds them: lines in the points' tangent planes, to a thirtieth of a
// milliradian. Neither way calls the C library's trigonometry, so that all machines decode the same bits.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "furrow/types.h"

namespace furrow {

// What is stored a point.
struct PackedDirection {
  uint8_t low, high;   // of encodeLine()
  uint8_t confidence;  // 0 to 127
  uint8_t defined;     // 1, or 0 where there is no direction
};
static_assert(sizeof(PackedDirection) == 4);

// A unit direction orthogonal to the unit normal. In the normal's basis (x, y), turned so that y >= 0, x /
// (|x| + |y|) runs from 1 to -1 over 65536 steps; d and -d have one code.
uint16_t encodeLine(Float3 normal, Float3 direction);
Float3 decodeLine(Float3 normal, uint16_t code);

// `axis`, of any length but 0, in the tangent plane of every unit normal: unit directions, zero where the
// axis is along the normal, and as confidence the length of what is left of a unit axis.
void projectAxis(std::span<const Float3> normals, Float3 axis, std::vector<Float3>& directions,
                 std::vector<float>& confidence);

// `normals`, `directions` (unit; zero: none) and `confidence` ([0, 1]) of every point.
std::vector<PackedDirection> packDirections(std::span<const Float3> normals,
                                            std::span<const Float3> directions,
                                            std::span<const float> confidence);
std::vector<Float3> unpackDirections(std::span<const Float3> normals,
                                     std::span<const PackedDirection> packed);

}  // namespace furrow

#include "direction_codec.h"

#include <algorithm>
#include <cmath>

#include "part_geometry.h"

namespace furrow {

namespace {

constexpr double kLeastLeft = 1e-6;  // of a unit axis

}

uint16_t encodeLine(Float3 normal, Float3 d) {
  Float3 t, b;
  tangentBasis(normal, t, b);
  const float y = (d.x * b.x + d.y * b.y) + d.z * b.z;
  const float x = ((d.x * t.x + d.y * t.y) + d.z * t.z) * (y < 0.0f ? -1.0f : 1.0f);
  const float sum = std::abs(x) + std::abs(y);
  if (!(sum > 0.0f)) return 0;
  return static_cast<uint16_t>(std::lround((1.0 - double{x / sum}) * 32768.0));  // 65536 is 0 again
}

Float3 decodeLine(Float3 normal, uint16_t code) {
  Float3 t, b;
  tangentBasis(normal, t, b);
  const float x = 1.0f - static_cast<float>(code) / 32768.0f, y = 1.0f - std::abs(x);
  const Float3 d = {x * t.x + y * b.x, x * t.y + y * b.y, x * t.z + y * b.z};
  const float length = std::sqrt((d.x * d.x + d.y * d.y) + d.z * d.z);
  return {d.x / length, d.y / length, d.z / length};
}

void projectAxis(std::span<const Float3> normals, Float3 axis, std::vector<Float3>& directions,
                 std::vector<float>& confidence) {
  const double wide[3] = {double{axis.x}, double{axis.y}, double{axis.z}};
  const double l = std::sqrt((wide[0] * wide[0] + wide[1] * wide[1]) + wide[2] * wide[2]);
  const double x = wide[0] / l, y = wide[1] / l, z = wide[2] / l;
  for (const Float3& n : normals) {
    const double along = (x * double{n.x} + y * double{n.y}) + z * double{n.z};
    const double dx = x - along * double{n.x}, dy = y - along * double{n.y}, dz = z - along * double{n.z};
    const double left = std::sqrt((dx * dx + dy * dy) + dz * dz);
    directions.push_back(left > kLeastLeft
                             ? Float3{static_cast<float>(dx / left), static_cast<float>(dy / left),
                                      static_cast<float>(dz / left)}
                             : Float3{});
    confidence.push_back(static_cast<float>(std::min(1.0, left)));
  }
}

std::vector<PackedDirection> packDirections(std::span<const Float3> normals,
                                            std::span<const Float3> directions,
                                            std::span<const float> confidence) {
  std::vector<PackedDirection> packed(normals.size());
  for (size_t p = 0; p < packed.size(); ++p) {
    const Float3 d = directions[p];
    if (d.x == 0.0f && d.y == 0.0f && d.z == 0.0f) continue;
    const uint16_t code = encodeLine(normals[p], d);
    packed[p] = {static_cast<uint8_t>(code), static_cast<uint8_t>(code >> 8),
                 static_cast<uint8_t>(std::lround(std::clamp(confidence[p], 0.0f, 1.0f) * 127.0f)), 1};
  }
  return packed;
}

std::vector<Float3> unpackDirections(std::span<const Float3> normals,
                                     std::span<const PackedDirection> packed) {
  std::vector<Float3> directions(packed.size());
  for (size_t p = 0; p < packed.size(); ++p)
    if (packed[p].defined)
      directions[p] = decodeLine(normals[p], static_cast<uint16_t>(packed[p].low | packed[p].high << 8));
  return directions;
}

}  // namespace furrow

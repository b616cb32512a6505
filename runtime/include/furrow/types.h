#pragma once

// Plain numbers that cross the runtime's interface.
//
// Conventions, here and everywhere in furrow: right-handed space as in glTF, +Y up; column vectors, p' = M p;
// lengths in the unit of the source file; UV origin at the top left of the image, v downwards, as in glTF.

#include <cstdint>

namespace furrow {

struct Float2 {
  float x, y;
};
struct Float3 {
  float x, y, z;
};
struct Float4 {
  float x, y, z, w;
};

// The upper three rows of an affine 4x4 matrix, row-major: p'.x = m[0] x + m[1] y + m[2] z + m[3].
struct Affine {
  float m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};

// M p, computed in double and rounded once.
inline Float3 transformed(const Affine& matrix, Float3 p) {
  const auto row = [&](int r) {
    const float* m = matrix.m + 4 * r;
    return static_cast<float>(((double{m[0]} * p.x + double{m[1]} * p.y) + double{m[2]} * p.z) + m[3]);
  };
  return {row(0), row(1), row(2)};
}

static_assert(sizeof(Float2) == 8 && sizeof(Float3) == 12 && sizeof(Float4) == 16 && sizeof(Affine) == 48);

inline constexpr uint32_t kAbsent = 0xffffffffu;  // "no index"

}  // namespace furrow

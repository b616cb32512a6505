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

static_assert(sizeof(Float2) == 8 && sizeof(Float3) == 12 && sizeof(Float4) == 16 && sizeof(Affine) == 48);

inline constexpr uint32_t kAbsent = 0xffffffffu;  // "no index"

}  // namespace furrow

#pragma once

// Instruction sets that the cpu tier's kernels are built for. They all give the same bits.

#include <cstdint>

namespace furrow {

enum class Simd : uint8_t { kPortable = 0, kSse4, kAvx2, kAvx512, kNeon };

const char* simdName(Simd simd);
// Whether this build and this CPU have it.
bool simdAvailable(Simd simd);
// The best that is available.
Simd bestSimd();

}  // namespace furrow

#include "furrow/simd.h"

#include <cstddef>
#include <initializer_list>

#include "src/targets.h"

#if HWY_ARCH_X86 && HWY_COMPILER_MSVC
#include <intrin.h>
#endif

namespace furrow {
namespace {

#if HWY_ARCH_X86 && !HWY_COMPILER_MSVC
bool cpuHasAvx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma");
}
bool cpuHasAvx512() {
  return cpuHasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512cd");
}
bool cpuHasSse4() {
  return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("pclmul") &&
         __builtin_cpu_supports("aes");
}
#elif HWY_ARCH_X86
bool cpuHas(int leaf, int word, int bit) {
  int words[4];
  __cpuidex(words, leaf, 0);
  return words[word] >> bit & 1;
}
// The operating system must save the registers too: XCR0.
bool cpuHasAvx2() {
  return cpuHas(1, 2, 27) && (_xgetbv(0) & 6) == 6 && cpuHas(7, 1, 5) && cpuHas(7, 1, 8) && cpuHas(1, 2, 12);
}
bool cpuHasAvx512() {
  return cpuHasAvx2() && (_xgetbv(0) & 0xe6) == 0xe6 && cpuHas(7, 1, 16) && cpuHas(7, 1, 17) &&
         cpuHas(7, 1, 28) && cpuHas(7, 1, 30) && cpuHas(7, 1, 31);
}
bool cpuHasSse4() {
  return cpuHas(1, 2, 20) && cpuHas(1, 2, 1) && cpuHas(1, 2, 25);
}
#endif

}  // namespace

const char* simdName(Simd simd) {
  constexpr const char* kNames[] = {"portable", "SSE4", "AVX2", "AVX-512", "NEON"};
  return kNames[static_cast<size_t>(simd)];
}

bool simdAvailable(Simd simd) {
  switch (simd) {
    case Simd::kPortable:
      return HWY_TARGETS & (HWY_SCALAR | HWY_EMU128);
#if HWY_ARCH_X86
    case Simd::kSse4:
      return HWY_TARGETS & HWY_SSE4 && cpuHasSse4();
    case Simd::kAvx2:
      return HWY_TARGETS & HWY_AVX2 && cpuHasAvx2();
    case Simd::kAvx512:
      return HWY_TARGETS & HWY_AVX3 && cpuHasAvx512();
#endif
    case Simd::kNeon:
      return HWY_TARGETS & HWY_NEON;
    default:
      return false;
  }
}

Simd bestSimd() {
  static const Simd best = [] {
    for (Simd simd : {Simd::kNeon, Simd::kAvx512, Simd::kAvx2, Simd::kSse4})
      if (simdAvailable(simd)) return simd;
    return Simd::kPortable;
  }();
  return best;
}

}  // namespace furrow

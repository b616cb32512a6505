#pragma once

// The instruction sets that Highway compiles kernels for, and a table of one function for all of them.
// To be included before any other header of Highway.

// NEON is all of ARM's that is wanted, and every CPU of 64 bits has it: no choice at run time, and with it no
// target attributes, which gcc would leave off implicit constructors.
#define TOOLCHAIN_MISS_SYS_AUXV_H
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
// Its assertions, in builds with a sanitizer, would need its library.
#define HWY_IS_DEBUG_BUILD 0
#include <hwy/detect_targets.h>

#include "furrow/simd.h"

#if HWY_TARGETS & HWY_SCALAR
#define FURROW_PORTABLE(function) &N_SCALAR::function
#elif HWY_TARGETS & HWY_EMU128
#define FURROW_PORTABLE(function) &N_EMU128::function
#else
#define FURROW_PORTABLE(function) nullptr
#endif
#if HWY_TARGETS & HWY_SSE4
#define FURROW_SSE4(function) &N_SSE4::function
#else
#define FURROW_SSE4(function) nullptr
#endif
#if HWY_TARGETS & HWY_AVX2
#define FURROW_AVX2(function) &N_AVX2::function
#else
#define FURROW_AVX2(function) nullptr
#endif
#if HWY_TARGETS & HWY_AVX3
#define FURROW_AVX512(function) &N_AVX3::function
#else
#define FURROW_AVX512(function) nullptr
#endif
#if HWY_TARGETS & HWY_NEON
#define FURROW_NEON(function) &N_NEON::function
#else
#define FURROW_NEON(function) nullptr
#endif

// To be indexed by Simd.
#define FURROW_TARGETS(function)                                                                      \
  {                                                                                                   \
    FURROW_PORTABLE(function), FURROW_SSE4(function), FURROW_AVX2(function), FURROW_AVX512(function), \
        FURROW_NEON(function)                                                                         \
  }

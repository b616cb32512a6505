#!/usr/bin/env bash
# fuzz.sh [JOBS [SECONDS [SEED]]]: builds the fuzz targets with libFuzzer and runs each for SECONDS (10) from SEED (1; 0: another in every run).
# Where there is no clang with libFuzzer, which the build does not need, it says so and is done: `make test` has replayed the seeds.
set -euo pipefail
jobs=${1:-$(nproc)}

if ! clang++ -fsanitize=fuzzer -x c++ -o /dev/null - 2>/dev/null <<<'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'; then
  echo "fuzz: skipped: no clang with libFuzzer (apt-get install clang libclang-rt-14-dev)"
  exit 0
fi
launcher=$(command -v ccache || true)
cmake --preset fuzz -DFURROW_FUZZ_SECONDS="${2:-10}" -DFURROW_FUZZ_SEED="${3:-1}" ${launcher:+-DCMAKE_CXX_COMPILER_LAUNCHER=$launcher}
cmake --build --preset fuzz -j "$jobs"
ctest --preset fuzz

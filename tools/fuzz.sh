#!/usr/bin/env bash
# fuzz.sh [JOBS]: builds the fuzz targets with libFuzzer and runs each for 10 seconds. Where there is no clang with libFuzzer, which the build
# does not need, it says so and is done: `make test` has replayed the seeds.
set -euo pipefail
jobs=${1:-$(nproc)}

if ! clang++ -fsanitize=fuzzer -x c++ -o /dev/null - 2>/dev/null <<<'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'; then
  echo "fuzz: skipped: no clang with libFuzzer (apt-get install clang libclang-rt-14-dev)"
  exit 0
fi
launcher=$(command -v ccache || true)
cmake --preset fuzz ${launcher:+-DCMAKE_CXX_COMPILER_LAUNCHER=$launcher}
cmake --build --preset fuzz -j "$jobs"
ctest --preset fuzz

#!/usr/bin/env bash
# bench.sh BUILD PAGE [PROGRAM...]: runs the benchmarks and writes their tables into PAGE (docs/performance.md), between its marks
# "<!-- generated: PROGRAM -->" and "<!-- end -->". Without PROGRAM, all that PAGE has marks for. Best on a machine with nothing else to do.
set -euo pipefail

build=$1 page=$2
shift 2
programs=("$@")
if [[ ${#programs[@]} -eq 0 ]]; then
  mapfile -t programs < <(sed -n 's/^<!-- generated: \([a-z_]*_bench\) -->$/\1/p' "$page")
fi
mkdir -p "$build/bench"
for program in "${programs[@]}"; do
  echo "$program" >&2
  if [[ $program == frame_bench ]]; then
    "$build/bin/$program" >"$build/bench/$program.json"
  else
    "$build/bin/$program" --benchmark_format=json >"$build/bench/$program.json"
  fi
done
python3 "$(dirname "$0")/performance.py" "$build" "$page" machine "${programs[@]}"

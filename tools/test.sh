#!/usr/bin/env bash
# test.sh BUILD [JOBS]: runs the tests of a build folder. The last line, also left in BUILD/test_summary.txt, is
# "N passed, N failed, N skipped"; the exit status is 0 only if none failed and there were some.
set -uo pipefail

build=$1
jobs=${2:-$(nproc)}
log=$build/test_log.txt

ctest --test-dir "$build" -j "$jobs" --output-on-failure --no-tests=error 2>&1 | tee "$log"
status=${PIPESTATUS[0]}

# "100% tests passed, 0 tests failed out of 33", in which skipped tests count as passed and disabled ones not at all.
read -r failed total < <(sed -n 's/^[0-9]*% tests passed, \([0-9]*\) tests\{0,1\} failed out of \([0-9]*\)$/\1 \2/p' "$log" | tail -n 1)
list=$(sed -n '/^The following tests did not run:/,/^$/p' "$log")
skipped=$(grep -c ' (Skipped)$' <<<"$list")
disabled=$(grep -c ' (Disabled)$' <<<"$list")
: "${total:=0}" "${failed:=0}"
[[ $status -eq 0 && ($total -eq 0 || $failed -ne 0) ]] && status=1
echo "$((total - failed - skipped)) passed, $failed failed, $((skipped + disabled)) skipped" | tee "$build/test_summary.txt"
exit "$status"

#!/usr/bin/env bash
# Tests that gfortran makes vector instructions of every loop over lanes in src/batch/nutate_lane_step.f90: one that is left
# scalar costs twice its time, and gives the same results, so that no other test would see it.
#    tools/check-vectors.sh
set -u
. "$(dirname "$0")/environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
source=$top/src/batch/nutate_lane_step.f90
# Each loop in the procedure where it stands. With gfortran alone: other compilers say what they do in other words.
bash tools/build.sh nutate_objects && cd "$scratch" || exit 1
# shellcheck disable=SC2086
gfortran -O3 ${unfused/ -fopenmp/} -fno-inline -fopt-info-vec-optimized -I "$cmake_folder/modules" -c "$source" \
   2>"$scratch/report" || exit 1

passed=0 failed=0
while IFS=: read -r line loop; do
   # The report gives a loop the line of its `do`, or, where one stands around it, of what is first in it.
   if grep -qE "lane_step.f90:($line|$((line + 1))|$((line - 1))):[0-9]+: optimized: loop vectorized" "$scratch/report"; then
      passed=$((passed + 1))
   else
      failed=$((failed + 1)) && say "FAILED: the loop of line $line is not vectorised"
   fi
done < <(grep -n 'do i = 1, lanes' "$source")
say "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -gt 20 ]

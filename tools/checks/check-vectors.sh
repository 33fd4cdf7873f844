#!/usr/bin/env bash
# Tests that gfortran makes vector instructions of every loop over lanes in src/batch/: one that is left scalar costs twice
# its time, and gives the same results, so that no other test would see it.
#    tools/checks/check-vectors.sh
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" && bash "$top/tools/setup/build.sh" nutate_objects || exit 1

passed=0 failed=0
for source in "$top"/src/batch/*.f90; do
   # Each loop in the procedure where it stands. With gfortran alone: other compilers say what they do in other words.
   # shellcheck disable=SC2086
   gfortran -O3 ${unfused/ -fopenmp/} -fno-inline -fopt-info-vec-optimized -I "$cmake_folder/modules" -c "$source" \
      2>"$scratch/report" || exit 1
   file=$(basename "$source")
   while IFS=: read -r line loop; do
      # The report gives a loop the line of its `do`, or, where one stands around it, of what is first in it.
      if grep -qE "$file:($line|$((line + 1))|$((line - 1))):[0-9]+: optimized: loop vectorized" "$scratch/report"; then
         passed=$((passed + 1))
      else
         failed=$((failed + 1)) && say "FAILED: the loop of $file, line $line, is not vectorised"
      fi
   done < <(grep -n 'do i = 1, lanes' "$source")
done
say "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -gt 30 ]

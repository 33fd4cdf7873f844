#!/usr/bin/env bash
# Tests src/batch as it is compiled: every loop over lanes becomes vector instructions (a scalar one costs twice its time and
# gives the same results, so that no other test would see it), and the bits of the bodies depend neither on how many are moved
# at once nor on the vector instructions. The last line is the total.
#    tools/checks/check-lanes.sh
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
bash tools/setup/build.sh nutate_static || exit 1
passed=0 failed=0

# Each loop in the procedure where it stands. With gfortran alone: other compilers say what they do in other words.
mkdir "$scratch/loops"
for source in src/batch/*.f90; do
   # shellcheck disable=SC2086
   gfortran -O3 ${unfused/ -fopenmp/} -fno-inline -fopt-info-vec-optimized -J "$scratch/loops" -I "$cmake_folder/modules" \
      -c "$source" -o "$scratch/loops/object.o" 2>"$scratch/report" || exit 1
   while IFS=: read -r line loop; do
      # The report gives a loop the line of its `do`, or, where one stands around it, of what is first in it.
      if grep -qE "$(basename "$source"):($line|$((line + 1))|$((line - 1))):[0-9]+: optimized: loop vectorized" "$scratch/report"; then
         passed=$((passed + 1))
      else
         failed=$((failed + 1)) && say "FAILED: the loop of $source, line $line, is not vectorised"
      fi
   done < <(grep -n 'do i = 1, lanes' "$source")
done
[ $passed -ge 10 ] || { failed=$((failed + 1)) && say "FAILED: only $passed loops over lanes were found"; }

# bits NAME WIDTH FLAG...: the states of bodies by src/batch with lanes of that width; the linker takes these modules before those of
# the library.
bits() {
   local folder=$scratch/$1 width=$2
   shift 2
   mkdir "$folder" && sed "s/public :: lanes = 16/public :: lanes = $width/" src/batch/nutate_lane_width.f90 >"$folder/width.f90" &&
      grep -q "lanes = $width\$" "$folder/width.f90" || return 1
   # shellcheck disable=SC2086
   gfortran -O3 $unfused "$@" -J "$folder" -I "$folder" -I "$cmake_folder/modules" "$folder/width.f90" src/batch/nutate_bodies_drift.f90 \
      src/batch/nutate_bodies.f90 tools/checks/bodies_bits.f90 -Wl,-z,muldefs "$cmake_folder/libnutate.a" -fopenmp -llapack -lblas \
      -o "$folder/bodies" && "$folder/bodies" >"$folder/bits" && [ "$(head -n 1 "$folder/bits")" = "$width lanes" ] &&
      tail -n +2 "$folder/bits" >"$folder/states" && [ "$(wc -l <"$folder/states")" -gt 6000 ]
}

ways=('one 1' 'four 4' 'eight 8')
! grep -q -w avx2 /proc/cpuinfo || ways+=('avx2 16 -mavx2')
! grep -q -w avx512vl /proc/cpuinfo || ways+=('avx512 16 -mavx512f -mavx512dq -mavx512vl -mprefer-vector-width=512 -fno-tree-slp-vectorize')
bits usual 16 || die "check-lanes: bodies by lanes of 16 do not run"
for way in "${ways[@]}"; do
   # shellcheck disable=SC2086
   if bits $way && cmp -s "$scratch/usual/states" "$scratch/${way%% *}/states"; then
      passed=$((passed + 1))
   else
      failed=$((failed + 1)) && say "FAILED: other bits of bodies: $way"
   fi
done
say "$passed passed, $failed failed"
[ $failed -eq 0 ]

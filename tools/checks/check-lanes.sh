#!/usr/bin/env bash
# Tests the kernels of src/batch and of the Taylor series as they are compiled: every loop over lanes becomes vector instructions
# (a scalar one costs twice its time and gives the same results, so that no other test would see it), what is compiled for AVX2 has
# its instructions and what is compiled for every processor has none, and the bits of the bodies depend neither on how many are
# moved at once nor on the vector instructions, nor do those of series and of tops. The last line is the total.
#    tools/checks/check-lanes.sh
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
bash tools/setup/build.sh nutate_static || exit 1
passed=0 failed=0

# Each loop in the procedure where it stands. With gfortran alone: other compilers say what they do in other words.
mkdir "$scratch/loops"
# loops SOURCE KERNEL PATTERN: the loops of a kernel whose first line has the pattern.
loops() {
   local line loop
   # shellcheck disable=SC2086
   gfortran -O3 ${unfused/ -fopenmp/} -fno-inline -fopt-info-vec-optimized -J "$scratch/loops" -I "$cmake_folder/modules" \
      -c "$1" -o "$scratch/loops/object.o" 2>"$scratch/report" || exit 1
   while IFS=: read -r line loop; do
      # The report gives a loop the line of its `do`, or, where one stands around it, of what is first in it.
      if grep -qE "$(basename "$2"):($line|$((line + 1))|$((line - 1))):[0-9]+: optimized: loop vectorized" \
         "$scratch/report"; then
         passed=$((passed + 1))
      else
         failed=$((failed + 1)) && say "FAILED: the loop of $(basename "$2"), line $line, is not vectorised"
      fi
   done < <(grep -n "$3" "$2")
}
for source in src/batch/nutate_drift_*2.f90; do
   loops "$source" src/batch/nutate_drift_kernel.inc 'do i = 1, lanes'
done
for source in src/batch/nutate_top_*2.f90; do
   loops "$source" src/batch/nutate_top_kernel.inc 'do i = 1, lane_count'
done
for source in src/methods/taylor/nutate_rows_*2.f90; do
   for kernel in rows free; do
      loops "$source" "src/methods/taylor/nutate_${kernel}_kernel.inc" 'do i = 1, 4$'
   done
done
[ $passed -ge 10 ] || { failed=$((failed + 1)) && say "FAILED: only $passed loops over lanes were found"; }

# registers MODULE: how many instructions of its procedures in the library use registers of AVX2.
registers() {
   objdump -d --no-show-raw-insn "$cmake_folder/libnutate.a" |
      awk -v module="<__$1_MOD_" '/^[0-9a-f]+ </ {inside = index($2, module) == 1} inside && /%ymm/ {n++} END {print n + 0}'
}

if [ "$(uname -m)" = x86_64 ]; then
   for kernel in drift top rows; do
      wide=$(registers nutate_${kernel}_avx2) narrow=$(registers nutate_${kernel}_sse2)
      if [ "$wide" -gt 100 ] && [ "$narrow" -eq 0 ]; then
         passed=$((passed + 1))
      else
         failed=$((failed + 1)) && say "FAILED: $wide instructions of AVX2 in the kernel of $kernel, $narrow in that of every processor"
      fi
   done
fi

# bits NAME WIDTH: the states of bodies by src/batch with lanes of that width; the linker takes these modules before those of the
# library.
bits() {
   local folder=$scratch/$1 width=$2
   mkdir "$folder" && sed "s/public :: lanes = 16/public :: lanes = $width/" src/batch/nutate_lane_width.f90 >"$folder/width.f90" &&
      grep -q "lanes = $width\$" "$folder/width.f90" || return 1
   # shellcheck disable=SC2086
   gfortran -O3 $unfused -J "$folder" -I "$folder" -I "$cmake_folder/modules" "$folder/width.f90" \
      src/batch/nutate_bodies_drift.f90 src/batch/nutate_drift_*2.f90 src/batch/nutate_bodies.f90 tools/checks/bodies_bits.f90 \
      -Wl,-z,muldefs "$cmake_folder/libnutate.a" -fopenmp -llapack -lblas -o "$folder/bodies" &&
      "$folder/bodies" >"$folder/bits" && is_whole "$folder" "$width"
}

# is_whole FOLDER WIDTH: FOLDER/bits has the states of all bodies by lanes of that width; they go to FOLDER/states.
is_whole() {
   [ "$(head -n 1 "$1/bits")" = "$2 lanes" ] && tail -n +2 "$1/bits" >"$1/states" && [ "$(wc -l <"$1/states")" -gt 6000 ]
}

# library_bits NAME [VARIABLE=VALUE]: the states by the library as it is.
library_bits() {
   local folder=$scratch/$1
   shift
   # shellcheck disable=SC2086
   mkdir "$folder" && gfortran -O3 $unfused -I "$cmake_folder/modules" -J "$folder" tools/checks/bodies_bits.f90 \
      "$cmake_folder/libnutate.a" -fopenmp -llapack -lblas -o "$folder/bodies" &&
      env "$@" "$folder/bodies" >"$folder/bits" && is_whole "$folder" 16
}

ways=('one bits 1' 'four bits 4' 'eight bits 8' 'sse2 library_bits NUTATE_SIMD=sse2')
library_bits usual || die "check-lanes: bodies by lanes of 16 do not run"
for way in "${ways[@]}"; do
   read -r name kind with <<<"$way"
   if "$kind" "$name" "$with" && cmp -s "$scratch/usual/states" "$scratch/$name/states"; then
      passed=$((passed + 1))
   else
      failed=$((failed + 1)) && say "FAILED: other bits of bodies: $way"
   fi
done

# Series of all effects, by both kinds of instructions.
bash tools/setup/build.sh || exit 1
for scene in all_effects heavy_top gyrocompass dual_spin; do
   for simd in avx2 sse2; do
      NUTATE_SIMD=$simd "$program" run "scenes/$scene.nml" --quiet --output "$scratch/$simd.csv" \
         --set "integrator.method='taylor'" --unset integrator.formulation --unset integrator.order || exit 1
   done
   if cmp -s "$scratch/avx2.csv" "$scratch/sse2.csv"; then
      passed=$((passed + 1))
   else
      failed=$((failed + 1)) && say "FAILED: other bits of the series of $scene"
   fi
done

# Tops of a sweep.
cat >"$scratch/tops.nml" <<'EOF'
&body inertia = 2.0, 3.0, 4.0, mass = 1.0, center_of_mass = 0.1, 0.0, 0.3 /
&gravity /
&initial quaternion = 0.8, 0.6, 0.0, 0.0, angular_velocity = 0.3, 1.0, 5.0 /
&integrator method = 'taylor', local_tolerance = 1e-9, end_time = 20.0 /
&ensemble members = 200 /
&vary key = 'initial.angular_velocity', distribution = 'uniform', low = 3*-5.0, high = 3*5.0 /
EOF
for simd in avx2 sse2; do
   NUTATE_SIMD=$simd "$program" sweep "$scratch/tops.nml" --quiet --output "$scratch/$simd.npy" || exit 1
done
if cmp -s "$scratch/avx2.npy" "$scratch/sse2.npy"; then
   passed=$((passed + 1))
else
   failed=$((failed + 1)) && say "FAILED: other bits of the tops of a sweep"
fi
say "$passed passed, $failed failed"
[ $failed -eq 0 ]

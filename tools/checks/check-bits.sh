#!/usr/bin/env bash
# Compares the histories of all scenes, by every kind of method, to the last bit: as written by the program of `make`, by the one
# that the tests run, by one tuned to this machine, and by those named. None may call the vector functions of libmvec, by which
# gfortran at -O3 takes sines of arrays, with other last digits. The last line is `N passed, N failed`.
#    tools/checks/check-bits.sh [PROGRAM]...
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
passed=0 failed=0

bash tools/setup/build.sh || exit 1
usual=$FFLAGS FFLAGS=$tested_flags
quietly build-tests build build-tests || exit 1
tested=$(fpm_path run nutate)
[ -n "$tested" ] || die "fpm does not say where it put the program"
cmake_folder=$top/build/cmake-native FFLAGS="$usual -march=native"
cmake_build build-native --target nutate_program || exit 1
programs=("$program" "$tested" "$cmake_folder/nutate")
# A copy of the first program needs no run.
for other; do cmp -s "$other" "$program" || programs+=("$other"); done

# What is set besides the scene; a scene that cannot be run so is refused by all.
ways=(
   "integrator.formulation='full'"
   "integrator.formulation='reduced'"
   "integrator.order=4"
   "integrator.method='rk4'"
   "integrator.method='dop853' integrator.conserve=.true."
   "integrator.method='rk8' integrator.conserve=.true."
   "integrator.method='taylor'"
   "integrator.method='exact'"
)

# history PROGRAM SCENE WAY: the rows, or the exit status. Nobody waits for a pendulum of hours by a method of low order.
history() {
   local setting settings=()
   for setting in $3; do settings+=(--set "$setting"); done
   "$1" run "$2" --quiet --output - --max-steps 100000 "${settings[@]}" 2>/dev/null || echo "exit status $?"
}

for other in "${programs[@]}"; do
   if nm -u "$other" | grep '_ZGV'; then
      failed=$((failed + 1)) && say "FAILED: vector functions in $other"
   else
      passed=$((passed + 1))
   fi
done

runs=0
for scene in scenes/*.nml; do
   for way in "${ways[@]}"; do
      history "$program" "$scene" "$way" >"$scratch/first"
      [ "$(wc -l <"$scratch/first")" -eq 1 ] || runs=$((runs + 1))
      for other in "${programs[@]:1}"; do
         if history "$other" "$scene" "$way" | cmp -s - "$scratch/first"; then
            passed=$((passed + 1))
         else
            failed=$((failed + 1)) && say "FAILED: other bits from $other: $scene $way"
         fi
      done
   done
done
say "$runs histories of each of ${#programs[@]} programs"
[ "$runs" -gt 0 ] || failed=$((failed + 1))
say "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

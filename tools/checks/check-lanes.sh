#!/usr/bin/env bash
# Tests that rows of ensembles depend neither on how many bodies are moved at once nor on the vector instructions: compares files
# of bodies alone, of builds with lanes of 1, 4 and 8, and of the usual width with AVX2 and AVX-512 where the machine has them.
#    tools/checks/check-lanes.sh [1|4|8|avx2|avx512]...      all of them unless named
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
bash tools/setup/build.sh || exit 1

cat >"$scratch/series.nml" <<'END'
&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&rotor momentum = 0.0, 10.0, 50.0 /
&integrator method = 'taylor', time_step = 0.1, end_time = 10.0 /
&output columns = 'quaternion', 'energy', every = 7 /
&ensemble members = 61, seed = 4, chunk = 61 /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 1.0, 9.0, 9.0 /
&vary key = 'body.inertia', distribution = 'uniform', low = 4.9, 18.0, 16.7, high = 5.1, 24.0, 17.3 /
END
cat >"$scratch/series_top.nml" <<'END'
&body inertia = 0.35, 0.3, 0.1, mass = 1.0, center_of_mass = 0.0, 0.0, 0.3 /
&initial angular_velocity = 0.0, 0.5, 10.0 /
&gravity acceleration = 0.0, 0.0, -9.8 /
&dipole moment = 0.0, 0.1, 2.0, field = 0.0, 0.0, 0.2 /
&integrator method = 'taylor', time_step = 0.04, end_time = 4.0 /
&output columns = 'quaternion', 'angular_momentum_space', every = 3 /
&ensemble members = 61, seed = 4, chunk = 61 /
&vary key = 'initial.quaternion', distribution = 'rotation' /
&vary key = 'initial.angular_velocity.3', distribution = 'normal', sigma = 8.0 /
END
cat >"$scratch/series_satellite.nml" <<'END'
&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.01, 0.02, 0.05 /
&gravity_gradient direction = 1.0, 2.0, -2.0, strength = 1e-2 /
&dipole moment = 0.0, 0.0, 0.2, field = 0.5, 0.0, 0.2 /
&rotor momentum = 0.0, 0.1, 0.5 /
&integrator method = 'taylor', time_step = 4.0, end_time = 400.0 /
&output columns = 'quaternion', 'energy' /
&ensemble members = 61, seed = 4, chunk = 61 /
&vary key = 'initial.quaternion', distribution = 'rotation' /
&vary key = 'gravity_gradient.strength', distribution = 'uniform', low = 0.0, high = 1e-2 /
END
sed -e 's/0.35, 0.3,/0.3, 0.3,/' -e '/^&dipole/d' "$scratch/series_top.nml" >"$scratch/series_axial_top.nml"
sed -e 's/^&gravity.*/\&rotor momentum = 0.0, 0.0, 0.01 \//' "$scratch/series_axial_top.nml" >"$scratch/series_axial.nml"
sed -e 's/inertia = 5.0, 20.0, 17.0/inertia_tensor = 5.0, 20.0, 17.0, 0.1, 0.2, -0.1/' -e "/'body.inertia'/d" \
   "$scratch/series.nml" >"$scratch/series_gyrostat.nml"
sed -e '/^&gravity/i &rotor momentum = 0.0, 0.1, 0.5 /' "$scratch/series_top.nml" >"$scratch/series_gyrostat_top.nml"
sed -e 's/5.0, 20.0, 17.0/20.0, 20.0, 17.0/' -e 's/0.0, 0.1, 0.5/0.0, 0.0, 0.5/' "$scratch/series_satellite.nml" \
   >"$scratch/series_axial_satellite.nml"
scenes=(series series_{top,axial_top,axial,gyrostat,gyrostat_top,satellite,axial_satellite})

passed=0 failed=0
# compare PROGRAM WAY [OPTION]...: its files with those of the program of `make`.
compare() {
   local scene
   for scene in "${scenes[@]}"; do
      "$1" sweep "$scratch/$scene.nml" --output "$scratch/other.npy" --quiet "${@:3}" >/dev/null
      if cmp -s "$scratch/other.npy" "$scratch/$scene.npy"; then
         passed=$((passed + 1))
      else
         failed=$((failed + 1)) && say "FAILED: $2: another file from $scene.nml"
      fi
      rm -f "$scratch/other.npy"*
   done
}
for scene in "${scenes[@]}"; do
   "$program" sweep "$scratch/$scene.nml" --output "$scratch/$scene.npy" --quiet >/dev/null || exit 1
done

# Chunks of one member have nothing to fill lanes with.
compare "$program" 'bodies alone' --set ensemble.chunk=1

# A copy of the sources, of which a build takes what has changed.
copy=$top/build/lanes
sources=(CMakeLists.txt fpm.toml src app include cmake bench link)
mkdir -p "$copy" && (cd "$copy" && rm -rf "${sources[@]}") && cp -r -p "${sources[@]}" "$copy" || exit 1
width=$copy/src/batch/nutate_lane_width.f90
# build_copy LANES WIDTH FLAGS: each kind of instructions has a folder, since other flags compile all anew.
build_copy() {
   folder=$copy/build-${1:-sse2}
   sed "s/public :: lanes = 16/public :: lanes = $2/" src/batch/nutate_lane_width.f90 >"$width"
   grep -q "lanes = $2\$" "$width" || die "src/batch/nutate_lane_width.f90 has no width to change"
   quietly lanes-configure cmake -S "$copy" -B "$folder" -DCMAKE_BUILD_TYPE=None -DNUTATE_WHOLE=OFF \
      -DCMAKE_Fortran_COMPILER="${FPM_FC:-gfortran}" -DCMAKE_Fortran_FLAGS="$3" -DCMAKE_C_FLAGS=-O2 -DNUTATE_LANES="$1" &&
      quietly lanes cmake --build "$folder" --parallel "$jobs" --target nutate_program
}
[ $# -gt 0 ] || set -- 1 4 8 avx2 avx512
for part; do
   case $part in
      avx2 | avx512)
         grep -q -w -e "${part/512/512vl}" /proc/cpuinfo || continue
         build_copy "$part" 16 "$FFLAGS" || exit 1
         ;;
      # Whatever the optimisation; -O1 compiles in a third of the time.
      1 | 4 | 8) build_copy '' "$part" -O1 || exit 1 ;;
      *) die "check-lanes: unknown part '$part' (1, 4, 8, avx2, avx512)" ;;
   esac
   compare "$folder/nutate" "lanes: $part"
done
say "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -ge 6 ]

#!/usr/bin/env bash
# What an event that never happens costs a run: instructions per step with it over those without, in per cent more, by callgrind
# from runs of two lengths, so that start and end cancel. The events are within reach: of energy, or of what keeps them away.
#    bench/event_overhead.sh PROGRAM FOLDER [METHOD]...   CASES: scenes, time steps, columns and values, a line each
set -eu
program=$1
shift 2
command -v valgrind >/dev/null || { echo 'skipped: valgrind is not here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
[ $# -gt 0 ] || set -- taylor dop853 rk8 rk4 nielsen_krenk:2 nielsen_krenk:4 nielsen_krenk:8

instructions() { # SCENE METHOD STEPS TIME_STEP
   local order=()
   case $2 in *:*) order=(--set "integrator.order=${2#*:}") ;; esac
   valgrind --tool=callgrind --callgrind-out-file="$folder/out" "$program" run "$1" --quiet --output "$folder/rows.csv" \
      --set "integrator.method='${2%:*}'" "${order[@]}" --set "integrator.time_step=$4" \
      --set "integrator.end_time=$(awk -v n="$3" -v h="$4" 'BEGIN {printf "%.12g", n*h}')" --set "output.every=$3" >/dev/null 2>&1
   sed -n 's/^summary: //p; s/^totals: //p' "$folder/out" | tail -n 1
}

short=300 long=1300
# Scene, time step, column, value.
cases=${CASES:-'fast_top 0.001 theta 0.5
fast_top 0.001 q0 1.01
fast_top 0.001 omega3 201
heavy_top 0.001 omega1 8
heavy_top 0.001 omega1 80
box 0.01 omega1 9
compass 0.02 omega3 4.8
spring_gyroscope 0.0005 theta 0.2
slowing_plate 0.005 omega1 12
all_effects 0.02 omega2 8
all_effects 0.02 l_z 40'}
printf 'Instructions with an event that never happens, per cent more a step, from %d and %d steps\n\n%-34s' $short $long ''
printf '%16s' "$@"
echo
while read -r scene step column value; do
   printf '%-34s' "$scene, $column = $value"
   { cat "scenes/$scene.nml"; printf "\n&event\n   name = 'never'\n   when = '%s'\n   crosses = %s\n/\n" "$column" "$value"; } \
      >"$folder/with.nml"
   cp "scenes/$scene.nml" "$folder/without.nml"
   for method; do
      for which in without with; do
         a=$(instructions "$folder/$which.nml" "$method" $short "$step")
         b=$(instructions "$folder/$which.nml" "$method" $long "$step")
         [ $which = without ] && bare=$((b - a)) || more=$((b - a - bare))
      done
      [ "$(wc -l <"$folder/rows.events.csv")" -eq 1 ] || { printf '\n%s: it happens\n' "$method"; exit 1; }
      awk -v b="$bare" -v m="$more" -v n=$((long - short)) 'BEGIN {printf "%8.0f %6.1f%%", b/n, 100*m/b}'
   done
   echo
done <<<"$cases"

#!/usr/bin/env bash
# What a scene without effects costs above the bare free step: instructions per step by callgrind, from runs of two lengths, so
# that start and end cancel.   bench/scene_overhead.sh PROGRAM FOLDER
set -eu
program=$1 free_step=$2/free_step
command -v valgrind >/dev/null || { echo 'skipped: valgrind is not here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

instructions() { # COMMAND...
   valgrind --tool=callgrind --callgrind-out-file="$folder/out" "$@" >/dev/null 2>&1
   sed -n 's/^summary: //p; s/^totals: //p' "$folder/out" | tail -n 1
}

short=2000 long=12000
printf 'Instructions per step of the box, from %d and %d steps\n\n%-10s%10s%10s%10s\n' $short $long solver bare scene ratio
for solver in full reduced; do
   for steps in $short $long; do
      bare[steps]=$(instructions "$free_step" $steps $solver)
      scene[steps]=$(instructions "$program" run scenes/box.nml --quiet --output /dev/null \
         --set "integrator.formulation='$solver'" --set "integrator.end_time=$((steps / 100))" --set "output.every=$steps")
   done
   awk -v b=$((bare[long] - bare[short])) -v s=$((scene[long] - scene[short])) -v n=$((long - short)) -v solver=$solver \
      'BEGIN {printf "%-10s%10.0f%10.0f%10.4f\n", solver, b/n, s/n, s/b}'
done

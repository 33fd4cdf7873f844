#!/usr/bin/env bash
# What the C interface costs above Fortran: instructions per step of the box by callgrind, from runs of two lengths, so that
# start and end cancel.   bench/interface_cost.sh PROGRAM FOLDER
#    one    a call of nutate_stepper_step for each step      against stepper%step
#    batch  one call of nutate_stepper_steps                 against stepper%step
#    run    one call of nutate_stepper_run                   against integrate, as the program calls it
set -eu
program=$1 free_step=$2/free_step c_steps=$2/c_steps
command -v valgrind >/dev/null || { echo 'skipped: valgrind is not here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

instructions() { # COMMAND...
   valgrind --tool=callgrind --callgrind-out-file="$folder/out" "$@" >/dev/null 2>&1
   sed -n 's/^summary: //p; s/^totals: //p' "$folder/out" | tail -n 1
}

fortran() { # WAY SOLVER STEPS
   if [ "$1" = run ]; then
      instructions "$program" run scenes/box.nml --quiet --output /dev/null --set "integrator.formulation='$2'" \
         --set "integrator.end_time=$(($3 / 100))" --set "output.every=$3"
   else
      instructions "$free_step" "$3" "$2"
   fi
}

short=2000 long=12000
printf 'Instructions per step of the box, from %d and %d steps\n\n%-10s%-8s%10s%10s%10s\n' $short $long solver way Fortran C ratio
for solver in full reduced; do
   for way in one batch run; do
      for steps in $short $long; do
         direct[steps]=$(fortran $way $solver $steps)
         c[steps]=$(instructions "$c_steps" $steps $solver $way)
      done
      awk -v d=$((direct[long] - direct[short])) -v c=$((c[long] - c[short])) -v n=$((long - short)) -v solver=$solver \
         -v way=$way 'BEGIN {printf "%-10s%-8s%10.1f%10.1f%10.4f\n", solver, way, d/n, c/n, c/d}'
   done
done

#!/usr/bin/env bash
# What the FORTRAN 77 interface costs above the library: instructions per step by callgrind, from runs of two lengths, so that
# start and end cancel; per step: of the bare stepper, of `integrate`, and of NUSTEP in calls of 1, 100 and 1000 steps.
#    bench/f77_cost.sh PROGRAM FOLDER
set -u
program=$2/f77_stepping
command -v valgrind >/dev/null || { echo 'skipped: valgrind is not here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

instructions() { # COMMAND...
   valgrind --tool=callgrind --callgrind-out-file="$folder/out" "$@" >/dev/null 2>&1
   sed -n 's/^summary: //p; s/^totals: //p' "$folder/out" | tail -n 1
}

short=1000 long=3000
calls='-1 0 1 100 1000'
printf 'Instructions per step, from %d and %d steps; in brackets: over integrate\n\n' $short $long
printf '%-8s%-9s%5s%9s%11s%18s%18s%18s\n' scene solver order bare integrate 'NUSTEP(1)' 'NUSTEP(100)' 'NUSTEP(1000)'
for scene in box top damped; do
   for solver in reduced full; do
      for order in 2 4; do
         line=
         for steps in $calls; do
            few=$(instructions "$program" $short "$steps" $scene $solver $order)
            many=$(instructions "$program" $long "$steps" $scene $solver $order)
            line="$line $((many - few))"
         done
         echo "$scene $solver $order $((long - short)) $line" |
            awk '{n = $4; printf "%-8s%-9s%5d%9.0f%11.0f", $1, $2, $3, $5/n, $6/n
                  for (i = 7; i <= 9; i++) printf "%10.0f (%5.3f)", $i/n, $i/$6; print ""}'
      done
   done
done

#!/usr/bin/env bash
# What Python costs above C: instructions of 1e5 steps of the box in one call of Stepper.run and of nutate_stepper_run, by
# callgrind, from runs of two lengths, so that start and end cancel.   bench/python_cost.sh PROGRAM FOLDER
set -u
c_steps=$2/c_steps
for tool in valgrind cmake python3; do
   command -v $tool >/dev/null || { echo "skipped: $tool is not here"; exit 0; }
done
python3 -c 'import numpy' 2>/dev/null || { echo 'skipped: Python has no NumPy here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bash tools/setup/install.sh "$folder/nutate" >/dev/null || exit 1

cat >"$folder/steps.py" <<'END'
import sys
import nutate
system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
stepper = nutate.Stepper(system, formulation="reduced", time_step=0.01)
stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
n = int(sys.argv[1])
stepper.run(n, every=n)
END

instructions() { # COMMAND...
   PYTHONHASHSEED=0 PYTHONPATH=$folder/nutate/share/nutate/python valgrind --tool=callgrind \
      --callgrind-out-file="$folder/out" "$@" >/dev/null 2>&1
   sed -n 's/^summary: //p; s/^totals: //p' "$folder/out" | tail -n 1
}

short=1000 long=101000
c=$(($(instructions "$c_steps" $long reduced run) - $(instructions "$c_steps" $short reduced run)))
python=$(($(instructions python3 "$folder/steps.py" $long) - $(instructions python3 "$folder/steps.py" $short)))
awk -v c=$c -v p=$python -v n=$((long - short)) 'BEGIN {
   printf "Instructions per step of the box, reduced: C %.1f, Python %.1f, ratio %.4f\n", c/n, p/n, p/c }'

#!/usr/bin/env bash
# Runs the unit tests and the program under valgrind: no invalid reads, no use of what was never set, nothing lost.
#    tools/tests/memcheck.sh [quick]      quick: without the suites that integrate for long, for every push
# The last line is `N passed, N failed`.
set -u
. "$(dirname "$0")/../environment.sh"

FFLAGS='-O1 -g'
# Suites that integrate for long by code which others cover too: they take most of the time.
long_suites='control resume round_off shipped_scenes stability_large_steps stability_scales stability_starts
stability_stiff stability_top threads work_precision'
cores=$(nproc)
# Tests try fewer of their random cases.
export NUTATE_SLOW_BUILD=1
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT

# examine NAME STATUS COMMAND...: starts it, as many at a time as there are cores; STATUS is the exit status that the
# command should have.
examine() {
   while [ "$(jobs -rp | wc -l)" -ge "$cores" ]; do wait -n; done
   assess "$@" &
}

# assess NAME STATUS COMMAND...: says what came of it, and leaves a file of the verdict.
assess() {
   local name=$1 expected=$2 log=$logs/memcheck-$1.log output=$scratch/$1.output started=$SECONDS
   shift 2
   valgrind --quiet --error-exitcode=99 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite \
      --suppressions=tools/tests/memcheck.supp --log-file="$log" "$@" >"$output" 2>&1 </dev/null
   if [ $? -eq "$expected" ]; then
      touch "$scratch/$name.passed"
      say "passed: $name ($((SECONDS - started)) s)"
   else
      touch "$scratch/$name.failed"
      say "FAILED: $name
$(tail -n 5 "$output")
$(head -n 40 "$log")"
   fi
}

# tally passed|failed: how many there are.
tally() { find "$scratch" -name "*.$1" | wc -l; }

say "Building with $FFLAGS"
build memcheck --tests || exit 1
unit=$(fpm_path test unit) nutate=$(fpm_path run nutate)
[ -n "$unit" ] && [ -n "$nutate" ] || die "fpm does not say where it put the programs"

for suite in $(suites); do
   if [ "${1:-}" = quick ] && [[ " ${long_suites//$'\n'/ } " == *" $suite "* ]]; then
      say "left to make memcheck: $suite"
   else
      examine "$suite" 0 "$unit" "$suite"
   fi
done
for scene in scenes/*.nml; do
   name=$(basename "$scene" .nml)
   step=$(sed -n 's/^ *time_step = *\([0-9.e-]*\).*/\1/p' "$scene")
   examine "check-$name" 0 "$nutate" check "$scene"
   examine "run-$name" 0 "$nutate" run "$scene" --output "$scratch/$name.csv" \
      --set integrator.end_time="$(awk "BEGIN {print 100*$step}")"
done
examine run-order-8 0 "$nutate" run scenes/box.nml --set integrator.order=8 --set integrator.end_time=0.5 --output -
examine cost 0 "$nutate" cost scenes/box.nml --evaluations 50000 --set integrator.end_time=0.2
for name in group_not_closed binary too_few_values triangle turn_per_step; do
   examine "refuse-$name" 2 "$nutate" check "test/cli/malformed/$name.nml"
done
examine fail 3 "$nutate" run scenes/box.nml --max-steps 10 --output "$scratch/failed.csv"
wait
failed=$(tally failed)
say "$(tally passed) passed, $failed failed"
[ "$failed" -eq 0 ]

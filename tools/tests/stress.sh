#!/usr/bin/env bash
# Runs the stability cases at full length, all groups or those named, puts their rows into docs/results/hard-cases.csv, what
# could go wrong in each into docs/results/hard-cases.txt, and the tables into docs/results/hard-cases.md. Fails if a case
# misses its bound. All groups are followed by the tests of `make test`, with all of their random cases, and by the tests that
# look at a clock, with nothing beside them.
#    tools/tests/stress.sh [GROUP]...
set -u
. "$(dirname "$0")/../environment.sh"

rows=docs/results/hard-cases.csv
parts=build/stress

quietly build-stress build build-stress --tests || exit 1
path=$(fpm_path test unit)
mkdir -p "$parts"
"$path" --stress >"$parts/cases.txt" || exit 1
cat "$parts/cases.txt" >docs/results/hard-cases.txt
tests='unit cli'
[ $# -eq 0 ] || tests=
# shellcheck disable=SC2046
[ $# -gt 0 ] || set -- $(sed -n 's/^\([a-z_]*\)\t.*/\1/p' "$parts/cases.txt")
for group; do rm -f "$parts/$group.csv"; done

# One process for each group, as many at a time as there are cores.
status=0
printf '%s\n' "$@" | xargs -P "$(nproc)" -I '{}' sh -c '"$0" --stress "$1" >"$2/$1.csv"' "$path" '{}' "$parts" || status=1
for group; do
   [ -s "$parts/$group.csv" ] || continue
   { grep -v "^$group," "$rows"; cat "$parts/$group.csv"; } >"$parts/rows.csv" && cat "$parts/rows.csv" >"$rows"
done
python3 tools/docs/hard_cases.py "$parts/cases.txt" "$rows" docs/results/hard-cases.md || status=1
# shellcheck disable=SC2086
[ -z "$tests" ] || NUTATE_ONE_IN=1 bash tools/tests/test.sh $tests as stress || status=1
if [ -n "$tests" ]; then
   prefix=$(mktemp -d) || exit 1
   trap 'rm -rf "$prefix"' EXIT
   bash tools/setup/setup.sh build && bash tools/setup/install.sh "$prefix" || exit 1
   NUTATE=$prefix/bin/nutate NUTATE_JOBS=1 python3 tools/tests/run_python_tests.py test/timing || status=1
   NUTATE_JOBS=1 bash tools/tests/test-python.sh "$prefix" timing || status=1
fi
exit $status

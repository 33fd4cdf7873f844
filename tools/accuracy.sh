#!/usr/bin/env bash
# Runs random scenes against the oracle of the tests, all of them, and puts the table that came out into docs/accuracy.md,
# between its markers; or one run again, or those from one to another (2001:4000). Fails if the accuracy was not kept.
#    tools/accuracy.sh [CASE[:CASE]]
set -u
. "$(dirname "$0")/environment.sh"

document=docs/accuracy.md
parts=build/accuracy

quietly build-accuracy build build-accuracy --tests || exit 1
path=$(fpm_path test unit)
[ $# -eq 0 ] || exec "$path" --accuracy "$@"

mkdir -p "$parts"
"$path" --accuracy >"$parts/kept.md"
status=$?
cat "$parts/kept.md"
[ -s "$parts/kept.md" ] && insert_part accuracy "$document" kept "$parts"
exit $status

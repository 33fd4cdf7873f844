#!/usr/bin/env bash
# Runs random scenes against the oracle of the tests, all of them, and puts the table that came out into docs/accuracy.md,
# between its markers; or one run again, or those from one to another (2001:4000). Then random free bodies against their
# closed solution; or one of them; then motions that die out. Fails if the accuracy was not kept, or an error of the closed
# solution exceeds its estimate.
#    tools/docs/accuracy.sh [CASE[:CASE]]
#    tools/docs/accuracy.sh exact [CASE]
#    tools/docs/accuracy.sh dying [CASE[:CASE]]
set -u
. "$(dirname "$0")/../environment.sh"

document=docs/accuracy.md
parts=build/accuracy

quietly build-accuracy build build-accuracy --tests || exit 1
path=$(fpm_path test unit)
[ "${1-}" != exact ] || exec "$path" --exact "${@:2}"
[ "${1-}" != dying ] || exec "$path" --dying "${@:2}"
[ $# -eq 0 ] || exec "$path" --accuracy "$@"

mkdir -p "$parts"
"$path" --accuracy >"$parts/kept.md"
status=$?
cat "$parts/kept.md"
[ -s "$parts/kept.md" ] && insert_part accuracy "$document" kept "$parts"
"$path" --exact || status=1
"$path" --dying || status=1
exit $status

#!/usr/bin/env bash
# Runs random scenes against the oracle of the tests, all of them, and puts the table that came out into docs/accuracy.md,
# between its markers; or one run again, or those from one to another (2001:4000). Fails if the accuracy was not kept.
#    tools/accuracy.sh [CASE[:CASE]]
set -u
. "$(dirname "$0")/environment.sh"

document=docs/accuracy.md
part=build/accuracy.md
begin='<!-- begin kept -->' end='<!-- end kept -->'

quietly build-accuracy build build-accuracy --tests || exit 1
path=$(fpm_path test unit)
[ $# -eq 0 ] || exec "$path" --accuracy "$@"

grep -qxF "$begin" "$document" && grep -qxF "$end" "$document" || die "accuracy: $document lacks its markers"
"$path" --accuracy >"$part"
status=$?
cat "$part"
[ -s "$part" ] && awk -v begin="$begin" -v end="$end" -v part="$part" '
   $0 == end {inside = 0}
   !inside {print}
   $0 == begin {inside = 1; while ((getline line < part) > 0) print line}
' "$document" >"$part.new" && cat "$part.new" >"$document"
exit $status

#!/usr/bin/env bash
# Runs random scenes against the oracle of the tests, all of them, and puts the tables that came out into
# docs/results/accuracy-costs.md, between its markers; or one run again, or those from one to another (2001:4000). Then random
# free bodies against their closed solution; or one of them; then motions that decay. Fails if the accuracy was not kept, or an
# error of the closed solution exceeds its estimate.
#    tools/docs/accuracy.sh [CASE[:CASE]]
#    tools/docs/accuracy.sh exact [CASE]
#    tools/docs/accuracy.sh dying [CASE[:CASE]]
set -u
. "$(dirname "$0")/../environment.sh"

document=docs/results/accuracy-costs.md
parts=build/accuracy

quietly build-accuracy build build-accuracy --tests || exit 1
path=$(fpm_path test unit)
[ "${1-}" != exact ] || exec "$path" --exact "${@:2}"
[ "${1-}" != dying ] || exec "$path" --dying "${@:2}"
[ $# -eq 0 ] || exec "$path" --accuracy "$@"

mkdir -p "$parts"
status=0
"$path" --accuracy >"$parts/kept.md" || status=1
"$path" --exact >"$parts/exact.txt" || status=1
# The page has the largest ratios in a line, not in a table.
awk -F ' *[|] *' '$3 ~ /^[0-9]+$/ {runs += $3; failures += $4; kinds = kinds (kinds == "" ? "" : ", ") $2 " " $5}
   END {print runs " runs, " failures " failures. Largest error over the estimate: " kinds "."}' "$parts/exact.txt" >"$parts/exact.md"
"$path" --dying >"$parts/dying.txt" || status=1
# The page has the counts in a line, not in a table.
awk -F ' *[|] *' '$2 ~ /`|h >|^runs|^failed|^estimate|^largest/ {line = line (line == "" ? "" : "; ") $2 " (" $3 ")"} /^[A-Z]/ {rest = rest "\n" $0}
   END {print line "." rest}' "$parts/dying.txt" >"$parts/dying.md"
for part in kept exact dying; do
   cat "$parts/$part.md"
   [ -s "$parts/$part.md" ] && insert_part accuracy "$document" "$part" "$parts"
done
exit $status

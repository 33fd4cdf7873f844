#!/usr/bin/env bash
# Tries to make the steppers accept another root than that of the true motion: 100 000 stages drawn at random, each judged by
# an oracle of the tests. Without arguments the results go into docs/results/hard-cases.md. Fails if a wrong root counts as
# certified.
# Then looks for events that are missed, or made up, in 100 000 motions drawn at random, and in 20 000 more with levels,
# turning angles and torques that jump. Then compares the sensitivities of 100 000 random steps with those of 33 digits.
#    tools/tests/attack.sh [--seed S] [--stages N | --case K]      K repeats one case of a seed, stage by stage
#    tools/tests/attack.sh [--seed S] --events N | --event-case K  the motions alone
#    tools/tests/attack.sh [--seed S] --paths N | --path-case K    levels and extremes alone
#    tools/tests/attack.sh [--seed S] --tangents N | --tangent-case K  sensitivities alone
set -u
. "$(dirname "$0")/../environment.sh"

seed=1 stages=100000 case='' events='' event_case='' paths='' path_case='' tangents='' tangent_case='' whole=yes
while [ $# -gt 0 ]; do
   [ $# -gt 1 ] || die "attack: $1 needs a value"
   case $1 in
      --seed) seed=$2 ;;
      --stages) stages=$2 ;;
      --case) case=$2 ;;
      --events) events=$2 ;;
      --event-case) event_case=$2 ;;
      --paths) paths=$2 ;;
      --path-case) path_case=$2 ;;
      --tangents) tangents=$2 ;;
      --tangent-case) tangent_case=$2 ;;
      *) die "attack: unknown argument '$1'" ;;
   esac
   whole=no
   shift 2
done

quietly build-attack build build-attack --tests || exit 1
path=$(fpm_path test unit)
[ -n "$path" ] || die "fpm does not say where it put the tests"
[ -z "$event_case" ] || exec "$path" --attack-events "$seed" case "$event_case"
[ -z "$path_case" ] || exec "$path" --attack-paths "$seed" case "$path_case"
[ -z "$tangent_case" ] || exec "$path" --attack-tangents "$seed" case "$tangent_case"
[ -z "$tangents" ] || exec "$path" --attack-tangents "$seed" "$tangents"
[ -z "$paths" ] || exec "$path" --attack-paths "$seed" "$paths"
[ -z "$events" ] || exec "$path" --attack-events "$seed" "$events"
[ -z "$case" ] || exec "$path" --attack "$seed" case "$case"
[ "$whole" = yes ] || exec "$path" --attack "$seed" "$stages"

parts=build/attack
mkdir -p "$parts"
status=0
"$path" --attack "$seed" "$stages" >"$parts/attack.md" || status=1
"$path" --attack-events "$seed" 100000 >"$parts/events.md" || status=1
"$path" --attack-paths "$seed" 20000 >"$parts/paths.md" || status=1
"$path" --attack-tangents "$seed" 100000 >"$parts/tangents.txt" || status=1
# The page has the largest errors in a line, not in a table.
awk -F ' *[|] *' '/^\|/ && $6 ~ /E/ {line = line (line == "" ? "" : "; ") $2 " " $6} !/^\|/ {print}
   END {if (line != "") print "Largest errors: " line "."}' "$parts/tangents.txt" >"$parts/tangents.md"
for part in attack events paths tangents; do
   cat "$parts/$part.md"
   [ -s "$parts/$part.md" ] && insert_part attack docs/results/hard-cases.md "$part" "$parts"
done
exit $status

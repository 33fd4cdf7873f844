#!/usr/bin/env bash
# Runs the stability cases at full length, all groups or those named, and puts what came out into docs/stability.md,
# between the markers of each group. Fails if a case misses its bound.
#    tools/tests/stress.sh [GROUP]...
set -u
. "$(dirname "$0")/../environment.sh"

document=docs/stability.md
parts=build/stress

quietly build-stress build build-stress --tests || exit 1
path=$(fpm_path test unit)
mkdir -p "$parts"
# shellcheck disable=SC2046
[ $# -gt 0 ] || set -- $("$path" --stress)
for group; do rm -f "$parts/$group.md"; done

# One process for each group, as many at a time as there are cores.
status=0
printf '%s\n' "$@" | xargs -P "$(nproc)" -I '{}' sh -c '"$0" --stress "$1" >"$2/$1.md"' "$path" '{}' "$parts" || status=1
for group; do
   [ -s "$parts/$group.md" ] && insert_part stress "$document" "$group" "$parts"
done
exit $status

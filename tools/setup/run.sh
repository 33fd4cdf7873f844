#!/usr/bin/env bash
# Runs a scene and says where its CSV file is.   tools/setup/run.sh SCENE
set -u
. "$(dirname "$0")/../environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say which scene: make run SCENE=scenes/box.nml"
mkdir -p "$logs"
before=$logs/before-run
touch "$before"
"$program" run "$1" || exit
find . -maxdepth 2 -path ./build -prune -o -name '*.csv' -newer "$before" -printf 'Time history: %P\n'

#!/usr/bin/env bash
# Draws the figures of docs/figures/ from runs made here and now; the histories stay in build/figures/.
set -u
. "$(dirname "$0")/environment.sh"

data=build/figures

# simulate NAME SCENE [GROUP.KEY=VALUE]...: runs a scene into $data/NAME.csv.
simulate() {
   local name=$1 scene=$2 setting settings=()
   shift 2
   for setting; do settings+=(--set "$setting"); done
   quietly "figure-$name" "$program" run "$scene" --quiet --output "$data/$name.csv" "${settings[@]}" || exit 1
}

# draw NAME: runs tools/figures/NAME.gp, which reads from `data` and writes to `figure`.
draw() {
   local figure=docs/figures/$1.svg
   quietly "figure-$1" gnuplot -e "data = '$data'; figure = '$figure'" "tools/figures/$1.gp" || exit 1
   say "Drawn: $figure"
}

mkdir -p "$data" docs/figures
simulate box_short scenes/box.nml integrator.time_step=0.01
simulate box_long scenes/box.nml integrator.time_step=0.1
draw box_omega

#!/usr/bin/env bash
# Draws the figures of docs/figures/ from runs made here and now; the histories stay in build/figures/.
set -u
. "$(dirname "$0")/../environment.sh"

data=build/figures

# simulate NAME SCENE [GROUP.KEY=VALUE]...: runs a scene into $data/NAME.csv.
simulate() {
   local name=$1 scene=$2 setting settings=()
   shift 2
   for setting; do settings+=(--set "$setting"); done
   quietly "figure-$name" "$program" run "$scene" --quiet --output "$data/$name.csv" "${settings[@]}" || exit 1
}

# sweep NAME SCENE [GROUP.KEY=VALUE]...: the rows of its members into $data/NAME.csv.
sweep() {
   local name=$1 scene=$2 setting settings=()
   shift 2
   for setting; do settings+=(--set "$setting"); done
   quietly "figure-$name" "$program" sweep "$scene" --quiet --output "$data/$name.npy" --csv "$data/$name.csv" \
      "${settings[@]}" || exit 1
}

# draw NAME: runs tools/docs/figures/NAME.gp, which reads from `data` and writes to `figure`.
draw() {
   local figure=docs/figures/$1.svg
   quietly "figure-$1" gnuplot -e "data = '$data'; figure = '$figure'" "tools/docs/figures/$1.gp" || exit 1
   say "Drawn: $figure"
}

mkdir -p "$data" docs/figures

# The animation of the README: the tennis-racket theorem.
simulate tennis_racket scenes/box.nml integrator.end_time=5 integrator.time_step=0.005 integrator.order=8 \
   "output.columns='quaternion','angular_velocity'"
quietly figure-tennis_racket python3 tools/docs/figures/tennis_racket.py "$data/tennis_racket.csv" \
   docs/figures/tennis_racket.svg || exit 1
say "Drawn: docs/figures/tennis_racket.svg"

# The figures of the paper: box_attitudes, box_omega, period_error, top_angles.
python3 tools/docs/paper.py "$program" || exit 1

# A gyrostat by the momentum of its rotor, and the heavy top by its time step, beside a reference.
for momentum in 0 20 60; do
   simulate "gyrostat_$momentum" scenes/gyrostat.nml "rotor.momentum=0,0,$momentum"
done
draw gyrostat
simulate heavy_top_exact scenes/heavy_top.nml integrator.accuracy=1e-12 integrator.method=taylor output.interval=0.01 \
   output.columns=quaternion
for halves in 1 2; do
   simulate "heavy_top_$halves" scenes/heavy_top.nml "integrator.time_step=$(awk -v n=$halves 'BEGIN {print 0.001/n}')" \
      "output.every=$((10*halves))" "output.columns='quaternion','energy'"
   # Time, quaternion and energy residual of the run, then time and quaternion of the reference.
   awk -F, 'NR == FNR {line[FNR] = $1 "," $2 "," $3 "," $4 "," $5 "," $10; next} {print line[FNR] "," $0}' \
      "$data/heavy_top_$halves.csv" "$data/heavy_top_exact.csv" >"$data/heavy_top_$halves.both" || exit 1
done
draw heavy_top

# Events: the flips of the box, and bang-bang control.
simulate intermediate_axis scenes/intermediate_axis.nml
draw flips
simulate bang_bang scenes/bang_bang.nml
draw bang_bang

# Control: magnetorquers and wheels, and the motor of one wheel.
simulate detumbling scenes/detumbling.nml
draw detumbling
simulate dual_spin scenes/dual_spin.nml output.every=4
draw dual_spin

# The major-axis rule: a body with a viscous sphere, and with three frictional wheels of the same inertia.
simulate major_axis scenes/major_axis.nml
sed -e 's/1.7, 1.1, 0.9/2.0, 1.4, 1.2/' -e '/^&inner_sphere/,/^\//d' -e "s/, 'sphere1'//" scenes/major_axis.nml \
   >"$data/major_axis_wheels.nml"
for axis in '1, 0, 0' '0, 1, 0' '0, 0, 1'; do
   echo "&wheel axis = $axis, inertia = 0.3, friction = 0.5 /" >>"$data/major_axis_wheels.nml"
done
simulate major_axis_wheels "$data/major_axis_wheels.nml"
draw major_axis

# A gyrocompass on the turning Earth.
simulate gyrocompass scenes/gyrocompass.nml
draw gyrocompass

# Ensembles: a satellite after separation, and a book that is thrown by a steady hand, by another, and anyhow.
for seconds in 10 30 600; do
   sweep "separation_$seconds" scenes/separation.nml ensemble.members=20000 "integrator.end_time=$seconds"
done
draw separation
for percent in 1 3 10; do
   off=$(awk -v p="$percent" 'BEGIN {print 0.25*p}')
   sweep "thrown_book_$percent" scenes/thrown_book.nml "vary.sigma=$off,$off,$off"
done
draw thrown_book

# Roll, pitch and yaw on a circular orbit.
simulate earth_pointing scenes/earth_pointing.nml
draw earth_pointing

# Hyperion at the periapsis: from ANGLE,RATE (degrees, mean motions) over REVOLUTIONS.
periapses() {
   local name=$1 start=$2 revolutions=$3 end rate
   end=$(awk -v n="$revolutions" 'BEGIN {printf "%.6f", 6.283186*n}')
   rate=$(awk -v r="${start#*,}" 'BEGIN {printf "%.15g", 57.29577951308232*r}')
   simulate "hyperion_$name" scenes/hyperion.nml "integrator.end_time=$end" output.every=1000000 initial.degrees=T \
      "initial.roll_pitch_yaw=0,0,${start%,*}" "initial.angular_velocity=0,0,$rate"
}
periapses sea 0,1 1000
for start in 0,0.55 0,0.6 0,0.72 0,2.31 0,2.33 0,2.66 0,2.75 0,2.9 0,3.2 0,3.35 90,0.865 90,0.875; do
   periapses "island_$start" "$start" 100
done
draw hyperion
sweep chaos_map scenes/chaos_map.nml
draw chaos_map

# Apophis after its passage, by where it is in its rotation before.
simulate apophis_start scenes/apophis_ensemble.nml
sweep apophis_ensemble scenes/apophis_ensemble.nml
awk -v cells=36 -f tools/docs/figures/apophis_cells.awk "$data/apophis_start.csv" "$data/apophis_ensemble.csv" \
   >"$data/apophis_cells.csv" || exit 1
draw apophis_ensemble

# Attitudes by radar, and the motion that is fitted to them.
quietly figure-fit "$program" fit scenes/toutatis.nml --quiet --plot docs/figures/toutatis_fit.svg --output "$data/toutatis.fit.nml" \
   --csv "$data/toutatis.residuals.csv" || exit 1
say "Drawn: docs/figures/toutatis_fit.svg"

# The log of a gyroscope, and the motion that is fitted to it.
quietly figure-phone "$program" fit scenes/thrown_phone.nml --quiet --plot docs/figures/thrown_phone_fit.svg \
   --output "$data/thrown_phone.fit.nml" --csv "$data/thrown_phone.residuals.csv" || exit 1
say "Drawn: docs/figures/thrown_phone_fit.svg"

# A page of nutate view, and the bodies of the gallery, in a browser without a window, if there is one.
if bash tools/setup/setup.sh view; then
   page=$top/$data/box.html
   quietly figure-library bash tools/setup/build.sh nutate && PYTHONPATH=python NUTATE_LIBRARY=$cmake_folder/libnutate.so \
      quietly figure-page "$venv/bin/python" -c \
      "import nutate; nutate.view('scenes/box.nml', begin=0.055).save('$page')" || exit 1
   quietly figure-view chromium --headless --no-sandbox --hide-scrollbars --window-size=1000,640 --virtual-time-budget=5000 \
      --screenshot=docs/figures/view_box.png "file://$page" || exit 1
   say "Drawn: docs/figures/view_box.png"
   PYTHONPATH=python NUTATE_LIBRARY=$cmake_folder/libnutate.so quietly figure-gallery "$venv/bin/python" tools/docs/gallery.py \
      "$program" || exit 1
   say "Drawn: docs/gallery"
fi

# What accuracy costs: timings of this machine, which differ from run to run.
cost() { # SCENE
   local figure=docs/figures/cost_$1.svg
   quietly "figure-cost-$1" "$program" cost "scenes/$1.nml" --plot "$figure" --csv "$data/cost_$1.csv" || exit 1
   say "Drawn: $figure (table in $logs/figure-cost-$1.log)"
}
cost box
cost precessing_top
cost fast_top
cost heavy_top

# The layers, from the `use` statements.
python3 tools/lint/layers.py --write && say "Drawn: docs/figures/layers.svg"

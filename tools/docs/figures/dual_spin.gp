# The dual-spin turn: the momentum moves to the axis of the wheel. Components across that axis rotate fast; their
# magnitude is drawn.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/dual_spin.svg'" tools/docs/figures/dual_spin.gp

width = 840
height = 500
load 'tools/docs/figures/style.gp'
rows = data.'/dual_spin.csv'
across(a, b) = sqrt(a**2 + b**2)
set lmargin at screen 0.1
set rmargin at screen 0.72
set key at graph 1.02, 1 left top Left reverse samplen 2
set xrange [0:700]
set multiplot

set tmargin at screen 0.93
set bmargin at screen 0.67
set format x ''
set label 1 'angular momentum L / |l|' at graph 0, 1 left offset 0, 0.7
set yrange [0:1.1]
set ytics 0.5
plot rows using 't':(column('L1')/10) with lines linecolor rgb component[1] linewidth 1.6 title 'L_1, along the wheel', \
     rows using 't':(across(column('L2'), column('L3'))/10) with lines linecolor rgb component[3] linewidth 1.6 \
     title 'across it'

set tmargin at screen 0.6
set bmargin at screen 0.39
set label 1 'angular velocity Ω (rad/s)'
plot rows using 't':'omega1' with lines linecolor rgb component[1] linewidth 1.6 title 'Ω_1', \
     rows using 't':(across(column('omega2'), column('omega3'))) with lines linecolor rgb component[3] linewidth 1.6 \
     title 'across it'

set tmargin at screen 0.32
set bmargin at screen 0.15
set format x '%g'
set xlabel 't (s)'
set label 1 'wheel speed (rad/s)'
set yrange [0:110]
set ytics 50
plot rows using 't':'wheel1_speed' with lines linecolor rgb component[1] linewidth 1.6 title 'wheel 1'
unset multiplot

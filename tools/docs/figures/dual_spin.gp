# The dual-spin turn: where the momentum stands in the body, and how fast body and wheel turn.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/dual_spin.svg'" tools/docs/figures/dual_spin.gp

width = 840
height = 440
load 'tools/docs/figures/style.gp'
rows = data.'/dual_spin.csv'

set multiplot
set tmargin at screen 0.9
set bmargin at screen 0.17

# Direction of l in the body.
set lmargin at screen 0.1
set rmargin at screen 0.48
set title 'momentum in body axes' offset 0, -0.5
set xlabel 't  (s)'
set xtics 200
set xrange [0:700]
set ylabel 'L / |l|' offset 1, 0
set key top right horizontal opaque
set yrange [-0.3:1.3]
set ytics 0.5
plot for [i in '2 3 1'] rows using 't':(column('L'.i)/10) with lines linecolor rgb component[i + 0] linewidth 1 notitle, \
     for [i = 1:3] keyentry with lines linecolor rgb component[i] title sprintf('L_%d', i)

# Speeds: the body above, the wheel below.
set lmargin at screen 0.6
set rmargin at screen 0.97
set tmargin at screen 0.9
set bmargin at screen 0.55
set title 'angular velocity'
set xtics 200 format ''
unset xlabel
set yrange [-0.3:1.7]
set ylabel 'Ω  (rad/s)'
plot for [i in '2 3 1'] rows using 't':'omega'.i with lines linecolor rgb component[i + 0] linewidth 1 notitle, \
     for [i = 1:3] keyentry with lines linecolor rgb component[i] title sprintf('Ω_%d', i)

unset title
unset key
set tmargin at screen 0.48
set bmargin at screen 0.17
set xtics 200 format '%g'
set xlabel 't  (s)'
set yrange [0:110]
set ytics 50
set ylabel 'wheel speed  (rad/s)'
plot rows using 't':'wheel1_speed' with lines linecolor rgb component[1] linewidth 1.6
unset multiplot

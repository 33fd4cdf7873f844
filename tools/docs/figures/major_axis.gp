# The major-axis rule: the angular velocity of a body with a viscous sphere, and its energy, beside that of the same body
# with three frictional wheels.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/major_axis.svg'" tools/docs/figures/major_axis.gp

width = 840
height = 440
load 'tools/docs/figures/style.gp'
rows = data.'/major_axis.csv'
wheels = data.'/major_axis_wheels.csv'
set lmargin at screen 0.1
set rmargin at screen 0.78
set key at graph 1.02, 1 left top Left reverse samplen 2
set xrange [0:150]
set multiplot

set tmargin at screen 0.92
set bmargin at screen 0.55
set format x ''
set label 1 'angular velocity Ω (rad/s)' at graph 0, 1 left offset 0, 0.7
set yrange [-1.5:2.2]
set ytics 1
plot rows using 't':'omega1' with lines linecolor rgb component[1] linewidth 1.6 title 'Ω_1', \
     rows using 't':'omega2' with lines linecolor rgb component[2] linewidth 1.6 title 'Ω_2', \
     rows using 't':'omega3' with lines linecolor rgb component[3] linewidth 1.6 title 'Ω_3'

set tmargin at screen 0.46
set bmargin at screen 0.15
set format x '%g'
set xlabel 't (s)'
set label 1 'energy (J)'
set yrange [1.2:2.6]
set ytics 0.4
plot rows using 't':'total' with lines linecolor rgb component[3] linewidth 1.6 title 'sphere', \
     wheels using 't':'total' with lines linecolor rgb component[1] linewidth 1.6 title 'three wheels'

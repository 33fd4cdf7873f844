# A gyrocompass that finds north: where the axis of its rotor points, over four hours and as a path in the sky.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/gyrocompass.svg'" tools/docs/figures/gyrocompass.gp

width = 840
height = 420
load 'tools/docs/figures/style.gp'
rows = data.'/gyrocompass.csv'
degree = pi/180

# East, north and up of body axis 2.
east(q0, q1, q2, q3) = 2*(q1*q2 - q0*q3)
north(q0, q1, q2, q3) = q0**2 - q1**2 + q2**2 - q3**2
up(q0, q1, q2, q3) = 2*(q2*q3 + q0*q1)
azimuth(q0, q1, q2, q3) = atan2(east(q0, q1, q2, q3), north(q0, q1, q2, q3))/degree
elevation(q0, q1, q2, q3) = asin(up(q0, q1, q2, q3))/degree

set multiplot
set tmargin at screen 0.95
set bmargin at screen 0.18
unset key

set lmargin at screen 0.1
set rmargin at screen 0.5
set xrange [0:4]
set xtics 1
set yrange [-30:65]
set ytics 15
set xlabel 't  (h)'
set ylabel 'east of north  (°)'
plot rows using (column('t')/3600):(azimuth(column('q0'), column('q1'), column('q2'), column('q3'))) \
     with lines linecolor rgb component[2] linewidth 1.8

set lmargin at screen 0.61
set rmargin at screen 0.97
set xrange [-30:65]
set xtics 15
set yrange [-0.4:1.6]
set ytics 0.4
set format y '%.1f'
set xlabel 'east of north  (°)'
set ylabel 'above the horizon  (°)'
set object circle at first 0, 0.09774 size screen 0.004 fillcolor rgb mark fillstyle solid noborder front
set label 'rest' at first 4, 0.02 textcolor rgb mark front
plot rows using (azimuth(column('q0'), column('q1'), column('q2'), column('q3'))): \
     (elevation(column('q0'), column('q1'), column('q2'), column('q3'))) with lines linecolor rgb component[2] linewidth 1.8
unset multiplot

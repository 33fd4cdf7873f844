# The heavy top with two time steps: the attitude error grows, the energy residual stays at round-off.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/heavy_top.svg'" tools/docs/figures/heavy_top.gp

width = 840
height = 480
load 'tools/docs/figures/style.gp'
# Columns of both files side by side: those of the reference follow those of the run.
distance(q0, q1, q2, q3, r0, r1, r2, r3) = 4*asin(sqrt((q0 - r0)**2 + (q1 - r1)**2 + (q2 - r2)**2 + (q3 - r3)**2)/2)
error = '(distance($2, $3, $4, $5, $8, $9, $10, $11))'
set lmargin at screen 0.13
set rmargin at screen 0.72
set key at graph 1.02, 1 left top Left reverse samplen 2
set multiplot
set tmargin at screen 0.96
set bmargin at screen 0.56
set format x ''
set ylabel 'attitude error (rad)' offset 1, 0
set yrange [0:0.17]
set ytics 0.05
plot data.'/heavy_top_1.both' using 1:@error with lines linecolor rgb case_colour[3] linewidth 1.6 title 'steps of 1 ms', \
     data.'/heavy_top_2.both' using 1:@error with lines linecolor rgb case_colour[1] linewidth 1.6 title 'steps of 0.5 ms'
set tmargin at screen 0.5
set bmargin at screen 0.16
set format x '%g'
set xlabel 't (s)'
set ylabel 'energy residual / energy' offset 1, 0
set yrange [-1e-14:1e-14]
set ytics 5e-15
set format y '%.0te%T'
plot data.'/heavy_top_1.both' using 1:($6/5435.697) with lines linecolor rgb case_colour[3] linewidth 1.6 notitle, \
     data.'/heavy_top_2.both' using 1:($6/5435.697) with lines linecolor rgb case_colour[1] linewidth 1.6 notitle
unset multiplot

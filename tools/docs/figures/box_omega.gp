# The three components of the box's angular velocity in body axes, at two time steps.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/box_omega.svg'" tools/docs/figures/box_omega.gp

width = 840
height = 560
load 'tools/docs/figures/style.gp'
set style line 1 linecolor rgb case_colour[1] linewidth 1.6
set style line 2 linecolor rgb case_colour[3] linewidth 1 pointtype 7 pointsize 0.32

set ytics 4
set xrange [0:20]
set xtics 0, 2, 20
set format x ''
set lmargin at screen 0.11
set rmargin at screen 0.97

# Edges of the panels on the page, k = 0 at the top, and their scales.
top(k) = 0.91 - 0.275*k
bottom(k) = top(k) - 0.235
array least[3] = [-1, -10, -12]
array most[3] = [9, 10, 12]

set multiplot
do for [k = 0:2] {
   set tmargin at screen top(k)
   set bmargin at screen bottom(k)
   name = sprintf('omega%d', k + 1)
   set ylabel sprintf('Ω_%d  (rad/s)', k + 1)
   if (k == 0) { set key at screen 0.97, 0.985 right top horizontal samplen 2.5 } else { unset key }
   if (k == 2) { set format x '%g'; set xlabel 't  (s)' }
   set yrange [least[k + 1]:most[k + 1]]
   plot data.'/box_short.csv' using 't':name every 4 with lines linestyle 1 title 'Δt = 0.01 s', \
        data.'/box_long.csv' using 't':name with linespoints linestyle 2 title 'Δt = 0.1 s'
}
unset multiplot

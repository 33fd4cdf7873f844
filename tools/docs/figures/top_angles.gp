# The Euler angles of the precessing and the fast top over 1 s; of psi what differs from the mean spin.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/top_angles.svg'" tools/docs/figures/top_angles.gp

width = 840
height = 560
load 'tools/docs/figures/style.gp'
set style line 1 linecolor rgb case_colour[1] linewidth 1.6
set style line 2 linecolor rgb case_colour[3] linewidth 1.6

set xrange [0:1]
set xtics 0, 0.2, 1
set format x ''
set lmargin at screen 0.11
set rmargin at screen 0.97
top(k) = 0.91 - 0.275*k
bottom(k) = top(k) - 0.235
steady = data.'/precessing_top.csv'
fast = data.'/fast_top.csv'

set multiplot
set tmargin at screen top(0)
set bmargin at screen bottom(0)
set ylabel 'θ  (rad)'
set key at screen 0.97, 0.985 right top horizontal samplen 2.5
set ytics 0.2
set yrange [1:1.6]
plot steady using 't':'theta' with lines linestyle 1 title 'precessing top', \
     fast using 't':'theta' with lines linestyle 2 title 'fast top'
unset key
set tmargin at screen top(1)
set bmargin at screen bottom(1)
set ylabel 'φ  (rad)'
set ytics 4
set yrange [0:12]
plot steady using 't':'phi' with lines linestyle 1, fast using 't':'phi' with lines linestyle 2
set tmargin at screen top(2)
set bmargin at screen bottom(2)
set format x '%g'
set xlabel 't  (s)'
set ylabel 'ψ − mean spin  (rad)'
set ytics 0.1
set yrange [-0.2:0.1]
plot steady using 't':(column('psi') - 135.6*column('t')) with lines linestyle 1, \
     fast using 't':(column('psi') - 199.008543*column('t')) with lines linestyle 2
unset multiplot

# The Euler angles of the precessing and the fast top over 1 s; of psi what differs from the mean spin.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/top_angles.svg'" tools/docs/figures/top_angles.gp

set encoding utf8
set terminal svg size 840,560 fixed name 'top_angles' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

set style line 1 linecolor rgb '#0b3c5d' linewidth 1.6
set style line 2 linecolor rgb '#d55e00' linewidth 1.6

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid ytics linecolor rgb '#dddddd' linewidth 1 linetype 1
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
set ylabel 'θ  (rad)' offset 0.5, 0
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
set xlabel 't  (s)' offset 0, 0.3
set ylabel 'ψ − mean spin  (rad)'
set ytics 0.1
set yrange [-0.2:0.1]
plot steady using 't':(column('psi') - 135.6*column('t')) with lines linestyle 1, \
     fast using 't':(column('psi') - 199.008543*column('t')) with lines linestyle 2
unset multiplot

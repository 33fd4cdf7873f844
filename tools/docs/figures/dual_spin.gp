# The dual-spin turn: where the momentum stands in the body, and who turns.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/dual_spin.svg'" tools/docs/figures/dual_spin.gp

set encoding utf8
set terminal svg size 840,420 fixed name 'dual_spin' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid linecolor rgb '#e4e4e4' linewidth 1 linetype 1
set xlabel 't  (s)' offset 0, 0.3
rows = data.'/dual_spin.csv'
first = '#0b3c5d'
second = '#d55e00'
third = '#009e73'

set multiplot
set tmargin at screen 0.95
set bmargin at screen 0.18

# Direction of l in the body.
set lmargin at screen 0.1
set rmargin at screen 0.5
set xtics 200
set xrange [0:700]
set ylabel 'L / |l|' offset 1, 0
set key at graph 0.98, 0.6 right samplen 2 opaque
set yrange [-0.3:1.1]
plot rows using 't':(column('L1')/10) with lines linecolor rgb first linewidth 1.6 title 'L_1', \
     rows using 't':(column('L2')/10) with lines linecolor rgb second linewidth 1.0 title 'L_2', \
     rows using 't':(column('L3')/10) with lines linecolor rgb third linewidth 1.6 title 'L_3'

# Speeds.
set lmargin at screen 0.6
set rmargin at screen 0.97
set yrange [-0.3:1.5]
set key at graph 0.98, 0.97 right samplen 2 opaque
set ylabel 'rad/s' offset 1, 0
plot rows using 't':'omega1' with lines linecolor rgb first linewidth 1.6 title 'Ω_1', \
     rows using 't':'omega3' with lines linecolor rgb third linewidth 1.6 title 'Ω_3', \
     rows using 't':(column('wheel1_speed')/100) with lines linecolor rgb '#888888' dashtype 2 linewidth 1.6 title 'wheel / 100'
unset multiplot

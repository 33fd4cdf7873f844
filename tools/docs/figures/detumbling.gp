# Detumbling by B-dot up to 3000 s, then pointing by wheels: rates, and what the wheels turn with.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/detumbling.svg'" tools/docs/figures/detumbling.gp

set encoding utf8
set terminal svg size 840,420 fixed name 'detumbling' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid linecolor rgb '#e4e4e4' linewidth 1 linetype 1
set xlabel 't  (s)' offset 0, 0.3
rows = data.'/detumbling.csv'
first = '#0b3c5d'
second = '#d55e00'
third = '#009e73'

set multiplot
set tmargin at screen 0.95
set bmargin at screen 0.18

# Rates of the body.
set lmargin at screen 0.12
set rmargin at screen 0.5
set xtics 1000
set ylabel 'Ω  (rad/s)' offset 1, 0
set key top right samplen 2 opaque
set xrange [0:3400]
set yrange [-0.12:0.22]
plot rows using 't':'omega1' with lines linecolor rgb first linewidth 1.4 title 'Ω_1', \
     rows using 't':'omega2' with lines linecolor rgb second linewidth 1.4 title 'Ω_2', \
     rows using 't':'omega3' with lines linecolor rgb third linewidth 1.4 title 'Ω_3'

# The end: attitude error and speeds of the wheels.
set lmargin at screen 0.61
set rmargin at screen 0.97
set xrange [2990:3400]
set xtics 3000, 100
set yrange [-400:800]
set ylabel 'wheels  (rad/s)' offset 1, 0
plot rows using 't':'wheel1_speed' with lines linecolor rgb first linewidth 1.6 title 'ω_1', \
     rows using 't':'wheel2_speed' with lines linecolor rgb second linewidth 1.6 title 'ω_2', \
     rows using 't':'wheel3_speed' with lines linecolor rgb third linewidth 1.6 title 'ω_3', \
     rows using 't':(100*2*acos(abs(column('q0')) > 1 ? 1 : abs(column('q0')))) with lines linecolor rgb '#888888' \
        dashtype 2 linewidth 1.4 title '100 × error (rad)'
unset multiplot

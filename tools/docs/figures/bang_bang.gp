# Bang-bang attitude control in the phase plane: the fall to the switching lines, and the cycle that is left.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/bang_bang.svg'" tools/docs/figures/bang_bang.gp

width = 840
height = 420
load 'tools/docs/figures/style.gp'
set xlabel '2 q_3  (rad)'
rows = data.'/bang_bang.csv'
events = data.'/bang_bang.events.csv'
on(name) = strstrt(name, ' on') > 0

set multiplot
set tmargin at screen 0.9
set bmargin at screen 0.18

# All of it.
set lmargin at screen 0.12
set rmargin at screen 0.5
set title 'all 120 s' offset 0, -0.5
set xrange [-0.03:0.21]
set yrange [-0.07:0.03]
set xtics 0, 0.1, 0.2
set ytics 0.02
set ylabel 'Ω_3  (rad/s)'
set key at graph 0.99, 0.98 right top opaque
plot rows using (2*column('q3')):'omega3' with lines linecolor rgb component[3] linewidth 1.6 title 'attitude and rate', \
     events using (on(strcol('event')) ? 2*column('q3') : NaN):'omega3' with points linecolor rgb mark pointtype 7 \
        pointsize 0.4 title 'thrusters on', \
     events using (on(strcol('event')) ? NaN : 2*column('q3')):'omega3' with points linecolor rgb mark pointtype 6 \
        pointsize 0.5 linewidth 1.4 title 'off', \
     0.005 - 0.5*x with lines linecolor rgb grey dashtype 2 title 'switching lines', \
     -0.005 - 0.5*x with lines linecolor rgb grey dashtype 2 notitle

# The end: the last 60 s.
unset key
unset ylabel
set lmargin at screen 0.6
set rmargin at screen 0.97
set title 'the last 60 s'
set xrange [-0.012:0.012]
set yrange [-0.006:0.006]
set xtics -0.01, 0.01, 0.01
set ytics 0.002
late = 60
plot rows using (column('t') >= late ? 2*column('q3') : NaN):'omega3' with lines linecolor rgb component[3] linewidth 1.6, \
     events using (column('t') >= late && on(strcol('event')) ? 2*column('q3') : NaN):'omega3' with points \
        linecolor rgb mark pointtype 7 pointsize 0.4, \
     events using (column('t') >= late && !on(strcol('event')) ? 2*column('q3') : NaN):'omega3' with points \
        linecolor rgb mark pointtype 6 pointsize 0.5 linewidth 1.4, \
     0.005 - 0.5*x with lines linecolor rgb grey dashtype 2, -0.005 - 0.5*x with lines linecolor rgb grey dashtype 2
unset multiplot

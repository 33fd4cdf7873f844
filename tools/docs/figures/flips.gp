# The box on its intermediate axis: the middle component of its angular velocity, with its events marked.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/flips.svg'" tools/docs/figures/flips.gp

width = 840
height = 330
load 'tools/docs/figures/style.gp'
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.22
set xrange [0:20]
set xtics 0, 2, 20
set yrange [-12:12]
set ytics 4
set xlabel 't  (s)'
set ylabel 'Ω_3  (rad/s)'
set key at screen 0.97, 0.985 right top horizontal

rows = data.'/intermediate_axis.csv'
events = data.'/intermediate_axis.events.csv'
plot rows using 't':'omega3' with lines linecolor rgb component[3] linewidth 1.6 title 'Ω_3', \
     events using (strcol('event') eq 'flip' ? column('t') : NaN):'omega3' \
        with points linecolor rgb mark pointtype 7 pointsize 0.6 title 'flip', \
     events using (strcol('event') eq 'flip' ? NaN : column('t')):'omega3' \
        with points linecolor rgb mark pointtype 6 pointsize 0.7 linewidth 1.6 title 'turned over'

# The box on its intermediate axis: the middle component of its angular velocity, with its events marked.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/flips.svg'" tools/docs/figures/flips.gp

set encoding utf8
set terminal svg size 840,330 fixed name 'flips' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

# Two colours that differ for every kind of colour vision, and in lightness.
curve = '#0b3c5d'
mark = '#d55e00'

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid ytics linecolor rgb '#dddddd' linewidth 1 linetype 1
set lmargin at screen 0.09
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.22
set xrange [0:20]
set xtics 0, 2, 20
set yrange [-12:12]
set ytics 4
set xlabel 't  (s)' offset 0, 0.3
set ylabel 'Ω_3  (rad/s)' offset 0.5, 0
set key at screen 0.97, 0.985 right top horizontal samplen 2.5

plot data.'/intermediate_axis.csv' using 't':'omega3' with lines linecolor rgb curve linewidth 1.6 title 'Ω_3', \
     data.'/intermediate_axis.events.csv' using (strcol('event') eq 'flip' ? column('t') : NaN):'omega3' \
        with points linecolor rgb mark pointtype 7 pointsize 0.5 title 'flip', \
     data.'/intermediate_axis.events.csv' using (strcol('event') eq 'flip' ? NaN : column('t')):'omega3' \
        with points linecolor rgb mark pointtype 6 pointsize 0.7 linewidth 1.6 title 'turned over'

# Hyperion at each passage of the perigee: its angle in the plane against its rate, over the mean motion.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/hyperion.svg'" tools/docs/figures/hyperion.gp

set encoding utf8
set terminal svg size 840,560 fixed name 'hyperion' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

# Two colours that differ for every kind of colour vision, and in lightness.
sea = '#d55e00'
islands = '#0b3c5d'

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.92
set bmargin at screen 0.14
set xrange [-90:90]
set xtics 30
set yrange [0:3.6]
set ytics 0.5
set xlabel 'angle at the perigee  (°)' offset 0, 0.3
set ylabel 'rate over the mean motion' offset 1.5, 0
set key at screen 0.97, 0.985 right top horizontal samplen 1.5

# A body of three axes looks the same half a turn on.
half(x) = x - 180*floor((x + 90)/180)
angle(q0, q3) = half(360/pi*atan2(q3, q0))
starts = system("ls ".data."/hyperion_island_*.events.csv")
plot data.'/hyperion_sea.events.csv' using (angle(column('q0'), column('q3'))):'omega3' \
        with points linecolor rgb sea pointtype 7 pointsize 0.2 title 'from angle 0, rate 1', \
     for [i = 1:words(starts)] word(starts, i) using (angle(column('q0'), column('q3'))):'omega3' \
        with points linecolor rgb islands pointtype 7 pointsize 0.2 title (i == 1 ? 'regular motions' : '')

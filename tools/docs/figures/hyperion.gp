# Hyperion at the passages of its periapsis: a chaotic sea with islands of regular motions.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/hyperion.svg'" tools/docs/figures/hyperion.gp

width = 840
height = 600
load 'tools/docs/figures/style.gp'
unset grid
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.92
set bmargin at screen 0.14
set xrange [-90:90]
set xtics 30
set yrange [0:3.6]
set ytics 0.5
set xlabel 'angle of the long axis at the periapsis  (°)'
set ylabel 'Ω_3 at the periapsis / mean motion' offset 1, 0
set key at screen 0.97, 0.985 right top horizontal samplen 1

# A body of three axes looks the same half a turn on.
half(x) = x - 180*floor((x + 90)/180)
angle(q0, q3) = half(360/pi*atan2(q3, q0))
starts = system("ls ".data."/hyperion_island_*.events.csv")
plot data.'/hyperion_sea.events.csv' using (angle(column('q0'), column('q3'))):'omega3' \
        with points linecolor rgb mark pointtype 7 pointsize 0.35 title 'one chaotic motion', \
     for [i = 1:words(starts)] word(starts, i) using (angle(column('q0'), column('q3'))):'omega3' \
        with points linecolor rgb component[3] pointtype 7 pointsize 0.3 title (i == 1 ? 'regular motions' : '')

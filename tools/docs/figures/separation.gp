# How the long axis of a satellite spreads after separation: distributions of its angle from where it pointed at first.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/separation.svg'" tools/docs/figures/separation.gp

width = 840
height = 360
load 'tools/docs/figures/style.gp'
bin = 5.0
members = 20000.0
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.2
set xrange [0:180]
set xtics 0, 30, 180
set yrange [0:2.1]
set ytics 0.5
set xlabel 'angle of the long axis from its first direction  (°)'
set ylabel '% of members per degree' offset 1, 0
set key at screen 0.97, 0.985 right top horizontal

middle(angle) = bin*(floor(angle/bin) + 0.5)
# Of axis 3 from the third axis of space.
tilt(q1, q2) = acos(1 - 2*(q1**2 + q2**2))*180/pi
plot for [i = 1:3] data.'/separation_'.word('10 30 600', i).'.csv' \
   using (middle(tilt(column('q1'), column('q2')))):(100/(members*bin)) smooth frequency with histeps \
   linecolor rgb case_colour[i] linewidth 2 title 'after '.word('10 30 600', i).' s'

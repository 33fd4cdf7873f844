# Detumbling by B-dot up to 3000 s, then pointing by wheels: rates; then attitude error and speeds of the wheels.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/detumbling.svg'" tools/docs/figures/detumbling.gp

width = 840
height = 420
load 'tools/docs/figures/style.gp'
rows = data.'/detumbling.csv'

set multiplot

# Rates of the body.
set tmargin at screen 0.9
set bmargin at screen 0.17
set lmargin at screen 0.11
set rmargin at screen 0.49
set title 'B-dot, up to 3000 s' offset 0, -0.5
set xlabel 't  (s)'
set xtics 1000
set ylabel 'Ω  (rad/s)' offset 1, 0
set key top right horizontal opaque
set xrange [0:3400]
set yrange [-0.12:0.2]
set arrow 1 from 3000, graph 0 to 3000, graph 1 nohead linecolor rgb grey dashtype 2
plot for [i = 1:3] rows using 't':sprintf('omega%d', i) with lines linecolor rgb component[i] linewidth 1.4 \
     title sprintf('Ω_%d', i)
unset arrow 1

# The end: attitude error above, speeds of the wheels below.
set lmargin at screen 0.62
set rmargin at screen 0.97
set xrange [2990:3400]
set xtics 3000, 100 format ''
unset xlabel
set title 'pointing by wheels'
set tmargin at screen 0.9
set bmargin at screen 0.6
set yrange [0:*]
set ytics 1
set ylabel 'error  (rad)'
unset key
angle(q0) = 2*acos(abs(q0) > 1 ? 1 : abs(q0))
plot rows using 't':(angle(column('q0'))) with lines linecolor rgb '#000000' linewidth 1.6

unset title
set tmargin at screen 0.53
set bmargin at screen 0.17
set yrange [-400:800]
set ytics 400
set xtics 3000, 100 format '%g'
set xlabel 't  (s)'
set ylabel 'wheel speed  (rad/s)' offset 0.2, 0
set key at graph 0.98, 0.99 right top horizontal samplen 1 width -2 font ',13'
plot for [i = 1:3] rows using 't':sprintf('wheel%d_speed', i) with lines linecolor rgb component[i] linewidth 1.6 \
     title sprintf('wheel %d', i)
unset multiplot

# Roll, pitch and yaw of an Earth-pointing satellite over five revolutions.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/earth_pointing.svg'" tools/docs/figures/earth_pointing.gp

width = 840
height = 330
load 'tools/docs/figures/style.gp'
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.22
set xrange [0:5]
set xtics 0, 1, 5
set yrange [-30:30]
set ytics 10
set xlabel 'revolutions'
set ylabel 'angle  (°)'
set key at screen 0.97, 0.985 right top horizontal

rows = data.'/earth_pointing.csv'
turn = 2*pi
degree = pi/180
plot for [i = 1:3] rows using (column('true_anomaly')/turn):(column(word('roll pitch yaw', i))/degree) with lines \
     linecolor rgb component[i] linewidth 2 title word('roll pitch yaw', i)

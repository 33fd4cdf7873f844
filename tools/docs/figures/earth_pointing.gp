# Roll, pitch and yaw of an Earth-pointing satellite over five revolutions.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/earth_pointing.svg'" tools/docs/figures/earth_pointing.gp

set encoding utf8
set terminal svg size 840,330 fixed name 'earth_pointing' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

# Three colours that differ for every kind of colour vision, and in lightness.
roll = '#56b4e9'
pitch = '#d55e00'
yaw = '#0b3c5d'

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid ytics linecolor rgb '#dddddd' linewidth 1 linetype 1
set lmargin at screen 0.09
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.22
set xrange [0:5]
set xtics 0, 1, 5
set yrange [-30:30]
set ytics 10
set xlabel 'revolutions' offset 0, 0.3
set ylabel 'angle  (°)' offset 0.5, 0
set key at screen 0.97, 0.985 right top horizontal samplen 2.5

rows = data.'/earth_pointing.csv'
turn = 2*pi
degree = pi/180
plot rows using (column('true_anomaly')/turn):(column('roll')/degree) with lines linecolor rgb roll linewidth 2 title 'roll', \
     rows using (column('true_anomaly')/turn):(column('pitch')/degree) with lines linecolor rgb pitch linewidth 2 title 'pitch', \
     rows using (column('true_anomaly')/turn):(column('yaw')/degree) with lines linecolor rgb yaw linewidth 2 title 'yaw'

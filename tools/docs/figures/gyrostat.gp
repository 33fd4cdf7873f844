# The rate about the intermediate axis of a gyrostat, by the momentum of its rotor.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/gyrostat.svg'" tools/docs/figures/gyrostat.gp

width = 840
height = 360
load 'tools/docs/figures/style.gp'
set lmargin at screen 0.1
set rmargin at screen 0.72
set bmargin at screen 0.2
set tmargin at screen 0.95
set xlabel 't (s)'
set ylabel 'Ω_3 (rad/s)' offset 1, 0
set yrange [-11:11]
set ytics 5
set key at graph 1.02, 1 left top Left reverse samplen 2
plot data.'/gyrostat_0.csv' using 't':'omega3' with lines linecolor rgb case_colour[3] linewidth 1.6 title 'without rotor', \
     data.'/gyrostat_20.csv' using 't':'omega3' with lines linecolor rgb case_colour[2] linewidth 1.6 title 'rotor of 20 N m s', \
     data.'/gyrostat_60.csv' using 't':'omega3' with lines linecolor rgb case_colour[1] linewidth 1.6 title 'rotor of 60 N m s'

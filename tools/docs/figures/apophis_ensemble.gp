# The rotation of Apophis after its passage of 2029, by where it is in its rotation before: the distribution of the spin rate
# 2T/|l|, and a map.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/apophis_ensemble.svg'" tools/docs/figures/apophis_ensemble.gp

width = 900
height = 400
load 'tools/docs/figures/style.gp'
bin = 0.05
members = 10000.0
rate(t, x, y, z) = 2*t/sqrt(x**2 + y**2 + z**2)
stats data.'/apophis_start.csv' using (rate(column('kinetic'), column('l_x'), column('l_y'), column('l_z'))) \
   every ::0::0 name 'start' nooutput
ratio(t, x, y, z) = rate(t, x, y, z)/start_max
middle(r) = bin*(floor(r/bin) + 0.5)
rows = data.'/apophis_ensemble.csv'

set multiplot
set lmargin at screen 0.08
set rmargin at screen 0.44
set tmargin at screen 0.9
set bmargin at screen 0.17
set xrange [0.5:1.7]
set xtics 0.2
set yrange [0:*]
set xlabel 'spin rate after / before'
set ylabel '% of members per 0.05' offset 1, 0
set key at screen 0.3, 0.985 center top horizontal
set style fill solid 1
set boxwidth bin
plot rows using (middle(ratio(column('kinetic'), column('l_x'), column('l_y'), column('l_z')))):(100/members) \
        smooth frequency with boxes linecolor rgb case_colour[2] title 'all', \
     rows using (middle(ratio(column('kinetic'), column('l_x'), column('l_y'), column('l_z')))): \
        (column('short_axis_mode') < 0.5 ? 100/members : 0) smooth frequency with boxes linecolor rgb case_colour[3] \
        title 'long-axis mode'

unset grid
set lmargin at screen 0.54
set rmargin at screen 0.86
set xrange [0:1]
set xtics 0.25
set yrange [0:360]
set ytics 90
set xlabel 'rotation phase two days before'
set ylabel 'precession angle two days before  (°)' offset 1, 0
set cbrange [0.6:1.6]
set cbtics 0.2
set cblabel 'spin rate after / before' offset 1, 0
set palette defined (0.6 '#0b3c5d', 0.9 '#56b4e9', 1.0 '#f7f7f7', 1.2 '#e69f00', 1.6 '#d55e00')
set colorbox user origin screen 0.88, 0.17 size screen 0.02, 0.73
plot data.'/apophis_cells.csv' using 1:2:3 with image notitle
unset multiplot

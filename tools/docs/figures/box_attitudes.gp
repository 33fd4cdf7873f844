# The box at eight times, 0.4 s apart, side by side; the face with axis 3 is coloured.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/box_attitudes.svg'" tools/docs/figures/box_attitudes.gp

width = 1000
height = 160
load 'tools/docs/figures/style.gp'
set datafile separator whitespace
set size ratio -1
unset border
unset tics
unset key
set margins 0, 0, 0, 0
set xrange [-2.6:39]
set yrange [-3.6:2.6]
do for [k = 0:7] { set label k + 1 sprintf('t = %.1f s', 0.4*k) at 5.2*k, -3.2 center }
set style fill transparent solid 0.35 noborder
plot data.'/box_edges.dat' index 1 with filledcurves closed fillcolor rgb component[3], \
     data.'/box_edges.dat' index 0 with lines linecolor rgb '#000000' linewidth 1.4

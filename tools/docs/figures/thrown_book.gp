# The chance that a book thrown about its middle axis comes down on its back, by the number of turns that it makes.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/thrown_book.svg'" tools/docs/figures/thrown_book.gp

width = 840
height = 360
load 'tools/docs/figures/style.gp'
set lmargin at screen 0.1
set rmargin at screen 0.97
set tmargin at screen 0.88
set bmargin at screen 0.2
set xrange [0.8:6.2]
set xtics 1, 1, 6
set yrange [0:102]
set ytics 25
set xlabel 'turns before it is caught (4 per second)'
set ylabel 'on its back  (%)' offset 1, 0
set key at screen 0.97, 0.985 right top horizontal

turns = 'column("integrator.end_time")*4'
back = '100*(column("theta") > pi/2)'
plot for [i = 1:3] data.'/thrown_book_'.word('1 3 10', i).'.csv' using (@turns):(@back) smooth unique with linespoints \
   linecolor rgb case_colour[i] linewidth 1.8 pointtype (9 - 2*i) pointsize 0.6 \
   title (i == 1 ? 'rate off by ' : '').word('1 3 10', i).' %'

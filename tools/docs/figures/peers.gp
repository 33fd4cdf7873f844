# Time to an attitude error of 1e-9 by motion, of nutate, heyoka, a loop in C and SciPy.
#    gnuplot -e "data = 'build/peers'; figure = 'docs/figures/peers.svg'" tools/docs/figures/peers.gp

width = 760
height = 420
load 'tools/docs/figures/style.gp'
set logscale x
set format x '10^{%L}'
set xlabel 'time to an attitude error of 10^{-9}  (µs)'
set yrange [-7.6:0.6]
set key outside right center
set xrange [10:*]
times = data.'/times.dat'
plot times using 4:1:yticlabels(2) with points linecolor rgb component[1] pointtype 7 pointsize 0.9 title 'nutate, taylor', \
     times using 5:1 with points linecolor rgb component[1] pointtype 6 pointsize 0.9 title 'nutate, rk8', \
     times using 3:1 with points linecolor rgb case_colour[2] pointtype 5 pointsize 0.9 title 'heyoka', \
     times using 6:1 with points linecolor rgb grey pointtype 9 pointsize 0.9 title 'C loop, RK8', \
     times using 7:1 with points linecolor rgb component[3] pointtype 11 pointsize 0.9 title 'SciPy DOP853'

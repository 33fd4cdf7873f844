# Relative error of the period of precession of two tops against ΩΔt, with the line (ΩΔt)²/12.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/period_error.svg'" tools/docs/figures/period_error.gp

set encoding utf8
set terminal svg size 640,460 fixed name 'period_error' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid linecolor rgb '#dddddd' linewidth 1 linetype 1
set logscale xy
set format y '10^{%L}'
set xlabel 'Ω₃Δt  (rad)'
set ylabel 'relative error of the precession period'
set key left top
set xrange [0.01:1]
plot x**2/12 with lines linecolor rgb '#888888' linewidth 1.5 dashtype 2 title '(Ω₃Δt)²/12', \
     data.'/period_precessing_top.dat' with linespoints linecolor rgb '#0b3c5d' linewidth 1.5 pointtype 7 pointsize 0.6 \
        title 'precessing top', \
     data.'/period_fast_top.dat' with linespoints linecolor rgb '#d55e00' linewidth 1.5 pointtype 5 pointsize 0.6 \
        title 'fast top'

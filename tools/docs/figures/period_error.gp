# Relative error of the period of precession of two tops against ΩΔt, with the line (ΩΔt)²/12.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/period_error.svg'" tools/docs/figures/period_error.gp

width = 640
height = 460
load 'tools/docs/figures/style.gp'
set datafile separator whitespace
set logscale xy
set format y '10^{%L}'
set xlabel 'Ω₃Δt  (rad)'
set ylabel 'relative error of the precession period'
set key left top
set xrange [0.01:1]
plot x**2/12 with lines linecolor rgb grey linewidth 1.5 dashtype 2 title '(Ω₃Δt)²/12', \
     data.'/period_precessing_top.dat' with linespoints linecolor rgb case_colour[1] linewidth 1.5 pointtype 7 pointsize 0.6 \
        title 'precessing top', \
     data.'/period_fast_top.dat' with linespoints linecolor rgb case_colour[3] linewidth 1.5 pointtype 5 pointsize 0.6 \
        title 'fast top'

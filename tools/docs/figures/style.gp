# What all figures share; a figure loads it after setting `width`, `height` and `figure`. One colour for one quantity, as in
# `nutate plot`: components 1, 2, 3 (and roll, pitch, yaw) have colours that differ for every kind of colour vision.

set encoding utf8
set terminal svg size width,height fixed name 'nutate' font 'Helvetica,Arial,sans-serif,15' background '#ffffff'
set output figure
set datafile separator comma

array component[3] = ['#d55e00', '#009e73', '#0b3c5d']
mark = '#e69f00'
grey = '#888888'
# Of sweeps: the colours of three cases.
array case_colour[3] = ['#000000', '#56b4e9', '#e69f00']

set border 3 linecolor rgb '#444444'
set tics nomirror out scale 0.6
set grid linecolor rgb '#e4e4e4' linewidth 1 linetype 1
set key samplen 2
set xlabel offset 0, 0.3

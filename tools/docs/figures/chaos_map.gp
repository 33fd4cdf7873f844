# The mean MEGNO of Hyperion's rotation over 50 revolutions, by angle and rate at the periapsis: islands in a chaotic sea.
#    gnuplot -e "data = 'build/figures'; figure = 'docs/figures/chaos_map.svg'" tools/docs/figures/chaos_map.gp

width = 840
height = 600
load 'tools/docs/figures/style.gp'
unset grid
set lmargin at screen 0.1
set rmargin at screen 0.84
set tmargin at screen 0.96
set bmargin at screen 0.14
set xrange [-91.25:91.25]
set xtics -90, 30, 90
set yrange [-0.025:3.625]
set ytics 0.5
set xlabel 'angle of the long axis at the periapsis  (°)'
set ylabel 'Ω_3 at the periapsis / mean motion' offset 1, 0
set cblabel 'mean MEGNO: 2 regular, more chaotic' offset 1, 0
set cbrange [0:20]
set cbtics 0, 2, 20
set palette defined (0 '#0b3c5d', 2 '#56b4e9', 4 '#f0e442', 10 '#e69f00', 20 '#d55e00')
set colorbox user origin screen 0.86, 0.14 size screen 0.025, 0.82

plot data.'/chaos_map.csv' using (180/pi*column('initial.roll_pitch_yaw.3')):'initial.angular_velocity.3':'megno' with image notitle

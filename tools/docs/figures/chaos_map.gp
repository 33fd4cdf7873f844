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
# Regular rotations are dark, chaotic ones bright; the lightness grows steadily, so that grey prints show it too.
set palette defined (0 '#0d0887', 2 '#1b068d', 3 '#6a00a8', 6 '#b12a90', 10 '#e16462', 15 '#fca636', 20 '#f0f921')
set colorbox user origin screen 0.86, 0.14 size screen 0.025, 0.82

plot data.'/chaos_map.csv' using (180/pi*column('initial.roll_pitch_yaw.3')):'initial.angular_velocity.3':'megno' with image pixels notitle

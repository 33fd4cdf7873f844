# Edges of the box of scenes/box.nml (4, 1, 2 m), seen obliquely, as segments in the plane for gnuplot, from a history with
# q0..q3: one box for each row, the k-th moved by 5.2 k. First the edges, then, after two blank lines, those of the face with
# axis 3, closed.
BEGIN { FS = ","; half[1] = 2; half[2] = 0.5; half[3] = 1 }
NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
{
   w = $column["q0"]; x = $column["q1"]; y = $column["q2"]; z = $column["q3"]; move = 5.2*(NR - 2)
   for (axis = 1; axis <= 3; axis++)
      for (a = -1; a <= 1; a += 2)
         for (b = -1; b <= 1; b += 2) {
            for (c = -1; c <= 1; c += 2) {
               s[axis] = c; s[axis % 3 + 1] = a; s[(axis + 1) % 3 + 1] = b
               print corner(s[1]*half[1], s[2]*half[2], s[3]*half[3])
            }
            print ""
         }
   face = face corner(half[1], half[2], half[3]) "\n" corner(-half[1], half[2], half[3]) "\n" \
          corner(-half[1], -half[2], half[3]) "\n" corner(half[1], -half[2], half[3]) "\n" \
          corner(half[1], half[2], half[3]) "\n\n"
}
END { printf "\n\n%s", face }

# R(q) v, seen from 20 degrees beside and 20 degrees above, moved.
function corner(a, b, c,    right, away, up) {
   right = (1 - 2*(y*y + z*z))*a + 2*(x*y - w*z)*b + 2*(x*z + w*y)*c
   away = 2*(x*y + w*z)*a + (1 - 2*(x*x + z*z))*b + 2*(y*z - w*x)*c
   up = 2*(x*z - w*y)*a + 2*(y*z + w*x)*b + (1 - 2*(x*x + y*y))*c
   return sprintf("%.5f %.5f", move + 0.94*right + 0.34*away, 0.94*up + 0.34*(0.94*away - 0.34*right))
}

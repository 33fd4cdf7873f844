# Mean rate of φ over a history of equal steps, weighted by (1 - cos)², which suppresses the nutation.
BEGIN { FS = "," }
NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
{ t[NR - 2] = $column["t"]; phi[NR - 2] = $column["phi"]; n = NR - 2 }
END {
   for (k = 1; k <= n; k++) {
      weight = (1 - cos(8*atan2(1, 1)*(k - 0.5)/n))^2
      sum += weight*(phi[k] - phi[k - 1]); total += weight*(t[k] - t[k - 1])
   }
   printf "%.12g\n", sum/total
}

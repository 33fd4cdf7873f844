# Means of the spin rate 2T/|l| after the passage over that before, in cells of the starts: reads a history from the start, then the
# rows of scenes/apophis_ensemble.nml, both as CSV, and writes centres of cells (turns, degrees) and means. -v cells=36, to each side.
function rate() { return 2*$at["kinetic"]/sqrt($at["l_x"]^2 + $at["l_y"]^2 + $at["l_z"]^2) }
BEGIN { FS = OFS = "," }
FNR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
NR == FNR { if (FNR == 2) before = rate(); next }
{
   i = int(cells*$at["initial.rotation_phase"])
   k = int(cells*$at["initial.precession_angle"]/360)
   sum[i, k] += rate()/before
   n[i, k]++
}
END {
   for (k = 0; k < cells; k++) for (i = 0; i < cells; i++)
      print (i + 0.5)/cells, (k + 0.5)*360/cells, n[i, k] ? sum[i, k]/n[i, k] : "NaN"
}

# Means of the spin rate after the passage over that before, in cells of the starts: reads the rows of
# scenes/apophis_ensemble.nml as CSV, writes centres of cells (turns, degrees) and means. -v cells=36, to each side.
BEGIN { FS = OFS = ","; before = 5.7446e-5 }
NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
{
   i = int(cells*$at["initial.rotation_phase"])
   k = int(cells*$at["initial.precession_angle"]/360)
   momentum = sqrt($at["l_x"]^2 + $at["l_y"]^2 + $at["l_z"]^2)
   sum[i, k] += 2*$at["kinetic"]/momentum/before
   n[i, k]++
}
END {
   for (k = 0; k < cells; k++) for (i = 0; i < cells; i++)
      print (i + 0.5)/cells, (k + 0.5)*360/cells, n[i, k] ? sum[i, k]/n[i, k] : "NaN"
}

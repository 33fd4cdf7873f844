"""An ensemble: how the time at which a tumbling box first turns over spreads, for starts that are not quite known."""

import sys

import numpy as np

import nutate

BOX = nutate.Scene(name="box", text="""
&body shape = 'box', size = 4, 1, 2, mass = 12 /
&initial angular_velocity = 0.1, 0, 10 /
&integrator accuracy = 1e-8, end_time = 10 /
&event name = 'turn', when = 'omega3', crosses = 0, stop = .true. /
&ensemble members = 200, seed = 1 /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.02, 0.02, 0.02 /
""")

rows = nutate.sweep(BOX)
times = rows["turn_first"]
print(f"{len(rows)} members turn over at {times.mean():.4f} s, spread {times.std():.4f} s, from {times.min():.4f} to {times.max():.4f} s")
counts, edges = np.histogram(times, bins=12)
for count, edge in zip(counts, edges):
    print(f"{edge:7.3f} s  {'#' * count}")
worst = max(rows["largest_energy_residual"].max(), rows["largest_momentum_error"].max())
ended = (rows["status"] == 0) & (rows["turn_count"] == 1) & (rows["t"] == times)
print(f"energy and momentum off by {worst:.1e} at most; all ended by the event: {ended.all()}")
sys.exit(int(not ended.all() or worst > 1e-13))

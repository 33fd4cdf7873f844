"""An ensemble: how the time at which a tumbling box first turns over spreads, for starts that are not quite known."""

import sys

import numpy as np

import nutate

MEMBERS, SPREAD = 200, 0.02  # rad/s

box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
random = np.random.default_rng(1)
starts = np.array([0.1, 0.0, 10.0]) + SPREAD * random.standard_normal((MEMBERS, 3))


def turns_over(t, q, omega):
    """0 where the spin about axis 3 changes its sense."""
    return omega[2]


turns_over.terminal = True
members = [nutate.solve(box, omega0=start, t_span=(0, 10), accuracy=1e-8, events=turns_over) for start in starts]
times = np.array([member.t_events[0][0] for member in members])
print(f"{MEMBERS} members turn over at {times.mean():.4f} s, spread {times.std():.4f} s, from {times.min():.4f} to {times.max():.4f} s")
counts, edges = np.histogram(times, bins=12)
for count, edge in zip(counts, edges):
    print(f"{edge:7.3f} s  {'#' * count}")
worst = max(member.errors["norm"] for member in members)
print(f"norm off by {worst:.1e} at most; all ended by the event: {all(member.status == 1 for member in members)}")
sys.exit(int(not all(member.status == 1 for member in members) or worst > 1e-14))

"""Runs what Nielsen & Krenk (2012) show and writes docs/results/paper.md: each of their statements beside the number of nutate,
and the figures that belong to it.

    python3 tools/docs/paper.py PROGRAM

Histories stay in build/figures/. The paper does not print its data: scenes/box.nml, precessing_top.nml and fast_top.nml say
where theirs come from.
"""

import csv
import math
import os
import subprocess
import sys

DATA = "build/figures"
PAGE = "docs/results/paper.md"
# Exact rates of precession, rad/s, and the spin about the axis of the cone (test/test_paper.f90).
TOPS = {"precessing_top": (10.0, 140.6), "fast_top": (4.998774, 200.0)}


class History:
    """The columns of a run, by name."""

    def __init__(self, program, name, scene, *settings):
        path = f"{DATA}/{name}.csv"
        command = [program, "run", f"scenes/{scene}.nml", "--quiet", "--output", path]
        for setting in settings:
            command += ["--set", setting]
        subprocess.run(command, check=True)
        with open(path, encoding="utf-8", newline="") as lines:
            rows = list(csv.reader(lines))
        self.columns = {key: [float(row[k]) for row in rows[1:]] for k, key in enumerate(rows[0])}

    def __getitem__(self, key):
        return self.columns[key]

    def drift(self, *keys):
        """Returns the largest change of a vector over its size at the start."""
        rows = list(zip(*(self[key] for key in keys)))
        return max(math.dist(row, rows[0]) for row in rows)/math.hypot(*rows[0])

    def size_drift(self, *keys):
        """Returns the largest relative change of the length of a vector."""
        sizes = [math.hypot(*row) for row in zip(*(self[key] for key in keys))]
        return max(abs(size/sizes[0] - 1) for size in sizes)

    def largest(self, key):
        return max(abs(value) for value in self[key])


def zero(values):
    """Returns where the polynomial through (0, values[0]), ..., (5, values[5]) vanishes between 2 and 3."""
    def at(x):
        return sum(y*math.prod((x - j)/(i - j) for j in range(6) if j != i) for i, y in enumerate(values))
    low, high = 2.0, 3.0
    for _ in range(50):
        middle = 0.5*(low + high)
        low, high = (middle, high) if at(middle)*values[2] > 0 else (low, middle)
    return low


def half_period(history, step):
    """Returns the mean time between zeros of the third angular velocity, each found by a polynomial of degree 5."""
    omega = history["omega3"]
    zeros = [step*(i - 2 + zero(omega[i - 2:i + 4])) for i in range(2, len(omega) - 3) if omega[i]*omega[i + 1] <= 0]
    return (zeros[-1] - zeros[0])/(len(zeros) - 1)


def precession(history):
    """Returns the mean rate of the precession, weighted by (1 - cos)², which suppresses the nutation."""
    phi, t = history["phi"], history["t"]
    n = len(phi) - 1
    weights = [(1 - math.cos(2*math.pi*(k + 0.5)/n))**2 for k in range(n)]
    return sum(w*(phi[k + 1] - phi[k]) for k, w in enumerate(weights))/sum(
        w*(t[k + 1] - t[k]) for k, w in enumerate(weights))


def period_errors(program, top):
    """Returns pairs of Ω₃Δt and the relative error of the period of precession, and writes them for the figure."""
    exact, omega = TOPS[top]
    points = []
    for k in range(11):
        step = 8/int(8*omega/(0.0141*1.5**k))
        history = History(program, f"{top}_{k}", top, f"integrator.time_step={step!r}", "integrator.end_time=8",
                          "output.columns='euler'")
        points.append((omega*step, abs(exact/precession(history) - 1)))
    with open(f"{DATA}/period_{top}.dat", "w", encoding="utf-8") as file:
        file.writelines(f"{x:.6g} {y:.6g}\n" for x, y in points)
    return points


def order(points):
    """Returns the order of an error: its slope over the steps from 0.03 to 0.3 rad, by least squares."""
    logs = [(math.log(x), math.log(y)) for x, y in points if 0.03 < x < 0.3]
    mean_x, mean_y = (sum(values)/len(logs) for values in zip(*logs))
    return sum((x - mean_x)*(y - mean_y) for x, y in logs)/sum((x - mean_x)**2 for x, _ in logs)


def factor(points):
    """Returns the mean factor of an error on (Ω₃Δt)²/12 up to 0.3 rad."""
    values = [12*y/x**2 for x, y in points if 0.03 < x < 0.3]
    return sum(values)/len(values)


def number(value):
    return f"{value:.1e}".replace("e-0", "e-").replace("e+0", "e+") if value else "0"


def box_rows(program):
    """Returns the rows of the table about the box."""
    columns = "output.columns='quaternion','angular_velocity','angular_momentum','angular_momentum_space','energy'," \
              "'conjugate_momentum','constraints'"
    # The figure reads the first two.
    runs = {step: History(program, name, "box", f"integrator.time_step={step}", columns)
            for step, name in ((0.01, "box_short"), (0.1, "box_long"))}
    periods = {step: half_period(history, step) for step, history in runs.items()}
    exact = half_period(History(program, "box_exact", "box", "integrator.method='exact'", columns), 0.01)
    loss = 100*(1 - periods[0.1]/periods[0.01])
    rows = [("Figure 2: time between turning points", "about 8 % shorter at $\\Delta t = 0.1$ than at 0.01",
             f"{loss:.2f} % ({periods[0.1]:.4f} s, {periods[0.01]:.4f} s; exact {exact:.4f} s)")]
    for what, values in (
            ("energy", [history.largest("energy_residual")/history["total"][0] for history in runs.values()]),
            ("global momentum", [history.drift("l_x", "l_y", "l_z") for history in runs.values()]),
            ("size of the local momentum", [history.size_drift("L1", "L2", "L3") for history in runs.values()])):
        rows.append((f"Box: error of the {what}", "within $10^{-12}$", " and ".join(map(number, reversed(values)))))
    worst = 0
    for k, inertia in enumerate(("0.2", "2.0", "20.0", "200.0", "Infinity")):
        history = History(program, f"box_inertia_{k}", "box", f"integrator.auxiliary_inertia={inertia}", columns)
        worst = max(worst, history.largest("orthogonality")/math.hypot(*(history[f"p{i}"][0] for i in range(4))))
    rows.append(("Orthogonality (5)", "to round-off, for any $J_0$", f"{number(worst)}, $J_0$ from 0.2 to $\\infty$"))
    return rows


def top_rows(program):
    """Returns the rows of the table about the tops."""
    rows = []
    for top in TOPS:
        name = top.replace("_", " ").capitalize()
        history = History(program, top, top)
        energy = history.largest("energy_residual")/history["total"][0]
        momentum = max(abs(value/history["l_z"][0] - 1) for value in history["l_z"])
        rows.append((f"{name}: errors of energy and $l_3$", "within the iteration tolerance",
                     f"{number(energy)} and {number(momentum)}"))
        free = History(program, f"{top}_free", top, "integrator.projection=F", "integrator.auxiliary_inertia=0.045",
                       "integrator.end_time=0.6")
        rows.append((f"{name} without the projection: error of the norm", "not conserved",
                     f"{free.largest('norm_error'):.2g} within 0.6 s, $J_0 = 10 J_1$"))
        if top == "fast_top":
            ratio = 2*history["potential"][0]/history["kinetic"][0]
            rows.append(("Fast top: $2V/T$ at the start", "below 0.05", f"{ratio:.3f}"))
    errors = []
    for k, inertia in enumerate((0.45, 4.5)):
        errors.append(History(program, f"top_inertia_{k}", "precessing_top", "integrator.projection=F",
                              f"integrator.auxiliary_inertia={inertia}", "integrator.end_time=0.02").largest("norm_error"))
    rows.append(("Error of the norm (2) for ten times the $J_0$", "in proportion to $1/J_0$", f"{errors[0]/errors[1]:.4f} times less"))
    for top in TOPS:
        points = period_errors(program, top)
        rows.append((f"Figure 3b: period error of the {top.replace('_', ' ')}", "$(\\Omega\\Delta t)^2/12$, second order",
                     f"{factor(points):.2f} times that, order {order(points):.2f}"))
    return rows


def draw(program):
    """Draws the figures from the histories of the runs above."""
    History(program, "box_attitudes", "box", "integrator.end_time=2.8", "output.every=40", "output.columns='quaternion'")
    with open(f"{DATA}/box_edges.dat", "w", encoding="utf-8") as file:
        subprocess.run(["awk", "-f", "tools/docs/figures/box_edges.awk", f"{DATA}/box_attitudes.csv"], stdout=file, check=True)
    for figure in ("box_attitudes", "box_omega", "period_error", "top_angles"):
        subprocess.run(["gnuplot", "-e", f"data = '{DATA}'; figure = 'docs/figures/{figure}.svg'",
                        f"tools/docs/figures/{figure}.gp"], check=True)


PAGE_TEXT = """# The paper reproduced

Made by `make paper`, which runs the scenes of the paper and draws its figures.

M. B. Nielsen and S. Krenk ([2012](../about/cite.md)) show a free box that rotates about its intermediate axis and a top under gravity. The paper does not
print its data. The top is the one commonly used with its reference [3]; the box, and the initial state of the fast top, are derived so that every
statement holds. If two errors are given for the box, the first is at
$\\Delta t = 0.1$ and the second at 0.01.

## Statements

| statement | paper | nutate |
|---|---|---|
{rows}
The errors of the period are fitted for $\\Omega_3\\Delta t$ from 0.03 to 0.3 rad.

## Figures

**Figure 1**: the box at eight times, $\\Delta t = 0.01$.

![The box at eight times, 0.4 s apart](../figures/box_attitudes.svg)

**Figure 2**: angular velocity of the box at two time steps.

![Components of the angular velocity of the box at two time steps](../figures/box_omega.svg)

**Figure 3a**: the angles of the top, of which the paper shows a sketch: $\\theta$, $\\varphi$, and $\\psi$ minus its mean rate times $t$.

![Euler angles of the precessing and the fast top](../figures/top_angles.svg)

**Figure 3b**: relative error of the period of precession against the rotation in a step.

![Relative error of the precession period of two tops against the rotation in a step](../figures/period_error.svg)
"""


def main(program):
    os.makedirs(DATA, exist_ok=True)
    rows = box_rows(program) + top_rows(program)
    draw(program)
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(PAGE_TEXT.format(rows="".join(f"| {' | '.join(row)} |\n" for row in rows)))
    print(f"Written: {PAGE}")


if __name__ == "__main__":
    main(*sys.argv[1:])

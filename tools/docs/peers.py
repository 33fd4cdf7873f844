"""Writes docs/results/peers.md and its figure from what bench/peers.py measured: build/peers/avx2.json and sse2.json.

    python3 tools/docs/peers.py
"""

import json
import math
import subprocess

DATA, PAGE = "build/peers", "docs/results/peers.md"
# Ways in the figure, in the order of its columns.
DRAWN = ["heyoka", "taylor", "rk8", "C, RK8", "SciPy"]

TEXT = """# Beside other integrators

Made by `make bench BENCH=bench_peers`. heyoka computes Taylor series that it compiles for each system of equations; it conserves nothing. nutate
conserves energy, momentum and norm in all runs.

Bodies with the moments 2, 3, 4 kg m² (the symmetric top 3, 3, 4) start at $q = (0.8, 0.6, 0, 0)$, $\\Omega = (0.3, 1, 5)$ rad/s, and
move for 20 s. Each time is the shortest of {rounds} interleaved runs on one core, in CPU time of the thread: `set_state` and `run_to` of nutate in Python,
`propagate_until` of heyoka, without compilation and set-up. The reference is heyoka in extended precision with the tolerance $10^{{-19}}$. For each
program the cheapest of many tolerances and steps is used.
Versions: {versions}.

## Time over that of heyoka

Below 1, nutate is faster. The method is the faster of `taylor` and `rk8`; *SSE2* is nutate with `NUTATE_SIMD=sse2`, beside heyoka as it is.

{ratios}
The geometric mean of `taylor` alone at $10^{{-9}}$ is {taylor} with AVX2 and {taylor_sse2} with SSE2.

## Times to an attitude error of 1e-9

In µs. The loops in C have the equations of each motion written out, fixed steps, and a normalised quaternion. RK8 is the method
of DOP853. SciPy evaluates the equations in Python.

![Time to an attitude error of 1e-9 by motion and program](../figures/peers.svg)

{times}
RK4 in C takes {rk4} µs, SciPy's DOP853 {scipy} ms. Torque-free bodies have a closed solution, which the ratios above leave out: `exact` takes
{exact} µs.

## Ensembles

512 bodies with random angular velocities on one thread, of which 95 % reach an attitude error of $10^{{-9}}$ (some tops are chaotic):
`nutate.sweep` with `exact` (free bodies only) and with `taylor`, and the batch mode of heyoka, which computes several bodies by the
same vector instructions. In µs a body; the ratio is that of the fastest method, `exact` included.

{ensembles}"""


def table(*rows):
    """Returns a table; the first row is its head."""
    return "".join("| " + " | ".join(row) + " |\n" + ("|---"*len(row) + "|\n" if i == 0 else "") for i, row in enumerate(rows))


def ratios(motions, goal, ways=("taylor", "rk8")):
    """Returns the time of the fastest of some ways over that of heyoka, by motion."""
    return [min(times[way][goal] for way in ways if times[way][goal])/times["heyoka"][goal] for times in motions.values()]


def mean(values):
    """Returns the geometric mean."""
    return math.exp(sum(map(math.log, values))/len(values))


def microseconds(value):
    """Returns a time in us with three digits."""
    return "–" if value is None else f"{1e6*value:.{max(0, 2 - math.floor(math.log10(1e6*value)))}f}"


def main():
    with open(f"{DATA}/avx2.json", encoding="utf-8") as file:
        avx2 = json.load(file)
    with open(f"{DATA}/sse2.json", encoding="utf-8") as file:
        sse2 = json.load(file)
    motions, middle = avx2["motions"], 1
    columns = [ratios(motions, goal) for goal in range(3)] + [ratios(sse2["motions"], middle)]
    rows = [[motion, *(f"{column[i]:.2f}" for column in columns)] for i, motion in enumerate(motions)]
    rows.append(["geometric mean", *(f"{mean(column):.2f}" for column in columns)])

    def times_of(ways):
        return [[motion, *(microseconds(times[way][middle]) for way in ways)] for motion, times in motions.items()]

    def span(way, unit):
        found = sorted(times[way][middle] for times in motions.values() if times[way][middle])
        return f"{unit*found[0]:.0f} to {unit*found[-1]:.0f}"
    with open(f"{DATA}/times.dat", "w", encoding="utf-8") as file:
        for i, (motion, times) in enumerate(motions.items()):
            file.write(",".join([str(-i), f'"{motion}"', *(f"{1e6*times[way][middle]:.4g}" if times[way][middle] else "nan" for way in DRAWN)]) + "\n")
    subprocess.run(["gnuplot", "-e", f"data = '{DATA}'; figure = 'docs/figures/peers.svg'", "tools/docs/figures/peers.gp"], check=True)
    text = TEXT.format(
        rounds=avx2["rounds"], versions=", ".join(f"{name} {version}" for name, version in avx2["versions"].items()),
        ratios=table(["motion", "1e-6", "1e-9", "1e-12", "1e-9, SSE2"], *rows),
        taylor=f"{mean(ratios(motions, middle, ['taylor'])):.2f}", taylor_sse2=f"{mean(ratios(sse2['motions'], middle, ['taylor'])):.2f}",
        times=table(["motion", "`taylor`", "`rk8`", "heyoka", "C, RK8"], *times_of(["taylor", "rk8", "heyoka", "C, RK8"])),
        rk4=span("C, RK4", 1e6), exact=microseconds(motions["torque-free"]["exact"][middle]), scipy=span("SciPy", 1e3),
        ensembles=table(["ensemble", "`exact`", "`taylor`", "heyoka", "ratio"], *(
            [name, *(microseconds(times.get(way)) for way in ("exact", "taylor", "heyoka")),
             f"{min(times.get('exact', math.inf), times['taylor'])/times['heyoka']:.2f}"] for name, times in avx2["ensembles"].items())))
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(text)
    print(f"Written: {PAGE}")


if __name__ == "__main__":
    main()

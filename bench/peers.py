"""Measures the time to a true attitude error against heyoka, SciPy and loops in C, and the time of ensembles; writes build/peers/NAME.json.

    python3 bench/peers.py NAME [--rounds N] [--motion NAME] [--own]

Called by bench/peers.sh. --own leaves out all but nutate and heyoka, and ensembles.
"""

import argparse
import ctypes
import json
import math
import time

import heyoka as hy
import numpy as np
import scipy
from scipy.integrate import solve_ivp

import nutate
from peers_motions import BODY, END, GRAVITY, MOTIONS, START, compiled, free, heavy

FOLDER = "build/peers"
GOALS = (1e-6, 1e-9, 1e-12)
# Tolerances, and steps of fixed length, whose errors of order 8 and 4 are as dense.
TOLERANCES = [10.0**(-k/4) for k in range(12, 65)]
STEPS = {8: [math.ceil(30*10**(k/32)) for k in range(80)], 4: [math.ceil(200*10**(k/16)) for k in range(60)]}
# A setting that takes more than this much of the cheapest one that reaches an error is not repeated. Longest run, s.
WORTH_REPEATING, PATIENCE = 1.25, 0.1
# Motions with a closed solution, which `exact` evaluates; their ratios are those of the other methods.
CLOSED = ("torque-free",)
# Part of an ensemble that must reach the accuracy: chaotic tops amplify round-off beyond it.
REACHED = 0.95
clock = time.thread_time_ns


def error_of(q, exact):
    """Returns the angle between two attitudes, rad."""
    return 2*min(np.linalg.norm(q - exact), np.linalg.norm(q + exact))


def heyoka_system(rate, size):
    """Returns the equations as heyoka wants them."""
    names = hy.make_vars(*(f"y{i}" for i in range(size)))
    return list(zip(names, rate(hy.time, names, hy.cos, hy.sqrt)))


def exact_attitude(system, start):
    """Returns the attitude at the end, by heyoka in extended precision."""
    start = [np.longdouble(value) for value in start]
    reference = hy.taylor_adaptive(system, start, tol=np.longdouble(1e-19), fp_type=np.longdouble)
    reference.propagate_until(np.longdouble(END))
    return np.array(reference.state[:4], dtype=np.float64)


def with_heyoka(system, start, tolerance):
    """Returns a run of heyoka, which returns the attitude at the end."""
    integrator, start = hy.taylor_adaptive(system, list(start), tol=tolerance), np.array(start)
    state = integrator.state

    def run():
        integrator.time = 0.0
        state[:] = start
        integrator.propagate_until(END)
        return state[:4]
    return run


def with_nutate(text, **settings):
    """Returns a run of a stepper from its state."""
    stepper = nutate.Stepper(nutate.System(text=text), **settings)
    stepper.set_columns("quaternion")
    q, omega = np.array(START[:4]), np.array(START[4:])

    def run():
        stepper.set_state(q, omega)
        stepper.run_to(END, 10**9)
        return stepper
    return run


def with_loop(function, start, n):
    """Returns a run of a loop in C."""
    start, state = np.array(start), np.array(start)
    address = state.ctypes.data

    def run():
        state[:] = start
        function(END, n, address)
        return state[:4]
    return run


def with_scipy(rate, start, tolerance):
    """Returns a run of SciPy's DOP853."""
    def derivative(t, y):
        return rate(t, y, math.cos, math.sqrt)
    return lambda: solve_ivp(derivative, (0.0, END), start, method="DOP853", rtol=max(tolerance, 3e-14), atol=tolerance).y[:4, -1]


def attitude(result):
    """Returns the attitude that a run returned."""
    return result.quaternion if isinstance(result, nutate.Stepper) else np.array(result)


def seconds(run):
    """Returns the time of a run, s."""
    start = clock()
    run()
    return 1e-9*(clock() - start)


def cheapest(runs, exact):
    """Returns, for each accuracy, the runs that reach it in about the least time."""
    tried = []
    for run in runs:
        error = error_of(attitude(run()), exact)
        tried.append([run, error, min(seconds(run) for _ in range(5))])
        if tried[-1][2] > PATIENCE or error < 1e-14:
            break
    # A second pass, since other work of the machine can slow down all runs of a while.
    for one in tried:
        one[2] = min(one[2], *(seconds(one[0]) for _ in range(5)))
    candidates = {}
    for goal in GOALS:
        reached = [one for one in tried if one[1] <= goal]
        least = min((one[2] for one in reached), default=0.0)
        candidates[goal] = [one[0] for one in reached if one[2] <= WORTH_REPEATING*least]
    return candidates


def measure(name, arguments):
    """Returns the times of one motion, s, by way and accuracy."""
    rate, extra, text = MOTIONS[name]
    start = (*START, *extra)
    system = heyoka_system(rate, len(start))
    exact = exact_attitude(system, start)
    # Runs are made when they are due: heyoka compiles for each tolerance.
    ways = {"taylor": (with_nutate(text, method="taylor", local_tolerance=tolerance, conserve=True) for tolerance in TOLERANCES),
            "rk8": (with_nutate(text, method="rk8", time_step=END/n, conserve=True) for n in STEPS[8]),
            "heyoka": (with_heyoka(system, start, tolerance) for tolerance in TOLERANCES)}
    if name in CLOSED:
        ways["exact"] = iter([with_nutate(text, method="exact", time_step=END)])
    if not arguments.own:
        loops = compiled(rate, extra, f"{FOLDER}/{name.replace(', ', '-')}")
        ways["C, RK8"] = (with_loop(loops.rk8, start, n) for n in STEPS[8])
        ways["C, RK4"] = (with_loop(loops.rk4, start, n) for n in STEPS[4])
        ways["SciPy"] = (with_scipy(rate, start, tolerance) for tolerance in TOLERANCES[8::2])
    candidates = {way: cheapest(runs, exact) for way, runs in ways.items()}
    # The shortest time of each candidate, in turn; the slow ones a few times.
    times = {}
    for i in range(arguments.rounds):
        for way, goals in candidates.items():
            for run in {id(run): run for runs in goals.values() for run in runs}.values():
                if i < 5 or times[id(run)] < 0.01*PATIENCE:
                    times[id(run)] = min(times.get(id(run), math.inf), seconds(run))
    # A run that reaches an error counts for the larger ones, too.
    result = {way: [min((times[id(run)] for tighter in GOALS[i:] for run in goals[tighter]), default=None) for i in range(len(GOALS))]
              for way, goals in candidates.items()}
    print(f"{name:18}" + "  ".join(way + "".join(f" {1e6*value:8.1f}" if value else "        -" for value in values)
                                   for way, values in result.items()), flush=True)
    return result


def ensemble(rate, text, closed, members, rounds):
    """Returns the times of ways to take an ensemble to 1e-9, s a member on one thread."""
    rates = np.random.default_rng(1).uniform(-5, 5, (members, 3))
    starts = np.concatenate([np.tile(START[:4], (members, 1)), rates], axis=1)
    system = heyoka_system(rate, 7)
    exact = [exact_attitude(system, start) for start in starts]
    table = {f"initial.angular_velocity.{i + 1}": rates[:, i] for i in range(3)}
    text += f" &initial quaternion = 0.8, 0.6, 0.0, 0.0, angular_velocity = 3*0.0 / &integrator end_time = {END}, "
    width = hy.recommended_simd_size()
    batches = starts.reshape(-1, width, 7).transpose(0, 2, 1).copy()
    ends = np.empty_like(batches)

    def sweep(settings):
        scene = nutate.Scene(text=f"{text}{settings} /")

        def run():
            end = nutate.sweep(scene, table=table, threads=1)
            return np.stack([end[f"q{i}"] for i in range(4)], axis=1)
        return run

    def batch(tolerance):
        integrator = hy.taylor_adaptive_batch(system, batches[0].copy(), tol=tolerance)

        def run():
            for start, end in zip(batches, ends):
                integrator.set_time(0.0)
                integrator.state[:] = start
                integrator.propagate_until(END)
                end[:] = integrator.state
            return ends.transpose(0, 2, 1).reshape(-1, 7)[:, :4]
        return run

    ways = {"taylor": (sweep(f"method = 'taylor', local_tolerance = {tolerance!r}") for tolerance in TOLERANCES),
            "heyoka": (batch(tolerance) for tolerance in TOLERANCES)}
    if closed:
        ways["exact"] = iter([sweep(f"method = 'exact', time_step = {END}")])
    result = {}
    for way, runs in ways.items():
        for run in runs:
            if np.quantile([*map(error_of, run(), exact)], REACHED) <= 1e-9:
                result[way] = min(seconds(run) for _ in range(rounds))/members
                break
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--motion", action="append", choices=[*MOTIONS])
    parser.add_argument("--own", action="store_true")
    arguments = parser.parse_args()
    result = {"versions": {"nutate": nutate.__version__, "heyoka": hy.__version__, "SciPy": scipy.__version__},
              "goals": GOALS, "rounds": arguments.rounds, "motions": {}, "ensembles": {}}
    print("  ".join(f"{package} {version}" for package, version in result["versions"].items()), flush=True)
    print(f"us to {', '.join(map(str, GOALS))}", flush=True)
    for motion in arguments.motion or MOTIONS:
        result["motions"][motion] = measure(motion, arguments)
    if not (arguments.own or arguments.motion):
        for name, rate, text in (("torque-free bodies", free, MOTIONS["torque-free"][2]),
                                 ("asymmetric tops", heavy((2.0, 3.0, 4.0)), MOTIONS["asymmetric top"][2])):
            result["ensembles"][name] = ensemble(rate, text, rate is free, 512, max(1, arguments.rounds//20))
            print(name, result["ensembles"][name], flush=True)
    with open(f"{FOLDER}/{arguments.name}.json", "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)


if __name__ == "__main__":
    main()

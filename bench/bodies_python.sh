#!/usr/bin/env bash
# What a step of 10,000 bodies costs from Python, over the same Runge-Kutta step by NumPy: ns a body-step, medians of steps in turn.
#    bench/bodies_python.sh PROGRAM FOLDER
set -u
python3 -c 'import numpy' 2>/dev/null || { echo 'skipped: Python has no NumPy here'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if [ -z "${NUTATE_LIBRARY-}" ]; then
   bash tools/setup/install.sh "$folder/nutate" >/dev/null || exit 1
   export PYTHONPATH=$folder/nutate/share/nutate/python
fi
OMP_NUM_THREADS=1 python3 - <<'END'
import statistics
import time

import numpy as np

import nutate

N, DT = 10000, 0.1
J = np.array([1.0, 2.0, 2.5])
C = np.array([J[1] - J[2], J[2] - J[0], J[0] - J[1]]) / J
random = np.random.default_rng(1)
q = random.normal(size=(N, 4))
q /= np.linalg.norm(q, axis=1, keepdims=True)
l, torque = random.uniform(-1, 1, (N, 3)), random.uniform(-0.05, 0.05, (N, 3))
state = np.concatenate([q, l / J], axis=1).T.copy()
body_torque = (torque / J).T.copy()


def rates(y):
    w, x, y1, z, a, b, c = y
    return np.stack([-0.5 * (x * a + y1 * b + z * c), 0.5 * (w * a + y1 * c - z * b), 0.5 * (w * b + z * a - x * c),
                     0.5 * (w * c + x * b - y1 * a), body_torque[0] + C[0] * b * c, body_torque[1] + C[1] * c * a,
                     body_torque[2] + C[2] * a * b])


def rk4():
    k1 = rates(state)
    k2 = rates(state + 0.5 * DT * k1)
    k3 = rates(state + 0.5 * DT * k2)
    k4 = rates(state + DT * k3)
    state[:] += DT / 6 * (k1 + 2 * (k2 + k3) + k4)
    state[:4] /= np.sqrt((state[:4] ** 2).sum(axis=0))


bodies = nutate.Bodies(nutate.System(moments=J), threads=1)
times = {"NumPy RK4": [], "Bodies.step": []}
for i in range(15):
    for name, call in (("NumPy RK4", rk4), ("Bodies.step", lambda: bodies.step(DT, q, l, torque))):
        start = time.thread_time_ns()
        for _ in range(20):
            call()
            np.negative(torque, out=torque)
            np.negative(body_torque, out=body_torque)
        times[name].append((time.thread_time_ns() - start) / (20 * N))
loop, step = (statistics.median(times[name]) for name in times)
print(f"Python, 10000 bodies, ns a body-step: NumPy RK4 {loop:.0f}, Bodies.step {step:.0f}, ratio {step / loop:.2f}")
END

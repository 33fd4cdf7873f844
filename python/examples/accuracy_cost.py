"""What accuracy costs: methods at a series of accuracies, against the exact motion of a free box."""

import sys
import time

import nutate

box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
q0, omega0, end = (1, 0, 0, 0), (0.1, 0, 10), 5.0
exact, _ = nutate.exact_free_body(box, q0, omega0, [end])
kept = True

print("method         accuracy     steps     ms     error (rad)  energy, rel.")
for method in ("nielsen_krenk", "dop853", "rk8", "taylor"):
    for accuracy in (1e-3, 1e-5, 1e-7, 1e-9):
        begun = time.perf_counter()
        solution = nutate.solve(box, q0, omega0, (0, end), accuracy=accuracy, method=method)
        spent = 1e3 * (time.perf_counter() - begun)
        error = nutate.attitude_distance(solution.q[-1], exact[0])
        kept = kept and error <= accuracy
        print(f"{method:14} {accuracy:8.0e} {solution.n_steps:9d} {spent:6.1f} {error:15.1e} {solution.errors['energy']:12.1e}")
print("every accuracy was kept" if kept else "an accuracy was missed")
sys.exit(int(not kept))

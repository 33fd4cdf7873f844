"""How soon Ctrl-C ends a run. `make stress` runs these tests, on a machine that does nothing else."""

import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests"))

import nutate  # noqa: E402  pylint: disable=wrong-import-position
import test_interrupts  # noqa: E402  pylint: disable=wrong-import-position
import test_sweeps  # noqa: E402  pylint: disable=wrong-import-position
from test_nutate import BOX, make_box  # noqa: E402  pylint: disable=wrong-import-position

# Processor time from the signal to the exception, s, for each thread that works.
SOON = 0.2


class Stop(test_interrupts.Stop):
    """Notes when the signal was sent."""

    def send(self):
        self.sent = time.process_time()
        super().send()


class PromptnessTest(test_interrupts.Interrupted):
    def stop(self, call, threads=1):
        with Stop(0.3) as stop, self.assertRaises(KeyboardInterrupt):
            call()
        self.assertLess(time.process_time() - stop.sent, threads * SOON)

    def test_runs_end_soon(self):
        self.stop(lambda: make_box().run(10 ** 9, every=1000))
        self.stop(lambda: make_box().steps(1e-3, 10 ** 11))
        self.stop(lambda: make_box(method="taylor", accuracy=1e-10).run_to(1e9, every=1000))
        self.stop(lambda: make_box(method="taylor", local_tolerance=1e-10).run_to(1e7, every=1000))
        self.stop(nutate.Scene(BOX, "integrator.end_time=1e7", "output.every=1000").run)

    def test_sweeps_end_soon(self):
        for threads in (1, 2)[:1 + test_sweeps.has_threads()]:
            for overrides in (("ensemble.members=1000000", "integrator.end_time=500"), ("ensemble.members=1", "integrator.end_time=1e9")):
                scene = nutate.Scene(None, *overrides, "output.every=1000000", text=test_sweeps.TUMBLE)
                self.stop(lambda scene=scene, threads=threads: nutate.sweep(scene, threads=threads), threads)


if __name__ == "__main__":
    test_interrupts.unittest.main()

"""What the tests of the command line share: a folder of their own, scenes, and running the program.

The environment variable NUTATE names the program."""
import csv
import functools
import os
import pathlib
import random
import re
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

BOX = """&scene title = 'Free box' /
&body shape = 'box', size = 4.0, 1.0, 2.0, mass = 12.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&integrator time_step = 0.01, end_time = 0.5 /
"""

TOP = """&body inertia = 5.0, 5.0, 1.0, mass = 1.0, center_of_mass = 0.0, 0.0, 1.0 /
&initial axis = 1.0, 0.0, 0.0, angle = 0.5, angular_velocity = 0.0, 0.0, 50.0 /
&gravity acceleration = 0.0, 0.0, -20.0 /
&integrator time_step = 0.005, end_time = 1.0 /
"""

# One case in how many is tried: 1 in `make stress`, 3 in `.ci/run`, 18 in `make test`.
ONE_IN = int(os.environ.get("NUTATE_ONE_IN") or 18)


def share_of(cases):
    """The part of so many cases that is tried, at least one."""
    return 1 + (cases - 1)//ONE_IN


def in_turn(number):
    """True for one in three successive numbers in `make test`, and for all numbers elsewhere: for loops over methods and scenes
    that all mean the same test."""
    return ONE_IN <= 3 or number % 3 == 0


# Time after which a program is considered to hang, s. Nothing else limits how long a program takes: machines are slow, or busy.
PATIENCE = 600
# Pause between two looks at what a program does, s.
PAUSE = 0.002

COLUMNS = {
    "quaternion": ["q0", "q1", "q2", "q3"],
    "conjugate_momentum": ["p0", "p1", "p2", "p3"],
    "angular_velocity": ["omega1", "omega2", "omega3"],
    "angular_velocity_space": ["omega_x", "omega_y", "omega_z"],
    "angular_speed": ["angular_speed"],
    "angular_momentum": ["L1", "L2", "L3"],
    "angular_momentum_space": ["l_x", "l_y", "l_z"],
    "euler": ["phi", "theta", "psi"],
    "energy": ["kinetic", "potential", "total", "work", "energy_residual"],
    "constraints": ["norm_error", "orthogonality"],
    "solver": ["iterations", "step_residual"],
    "jacobi": ["jacobi"],
    "time_dependent_work": ["time_dependent_work"],
    "roll_pitch_yaw": ["roll", "pitch", "yaw"],
    **{f"euler_{axes}": [f"euler_{axes}_{i}" for i in (1, 2, 3)]
       for axes in ("121", "123", "131", "132", "212", "213", "231", "232", "312", "321", "323")},
}
ORBIT_COLUMNS = {
    "lvlh_attitude": ["roll", "pitch", "yaw", "lvlh_q0", "lvlh_q1", "lvlh_q2", "lvlh_q3"],
    "lvlh_angular_velocity": ["lvlh_omega1", "lvlh_omega2", "lvlh_omega3"],
    "orbit": ["orbit_x", "orbit_y", "orbit_z", "orbit_radius", "true_anomaly"],
    "orbit_speed": ["orbit_speed"],
}
SUN_COLUMNS = {"eclipse": ["eclipse", "shadow_depth"], "sun_angle": ["sun_angle"]}
# Each stands for a column of each effect.
EFFECT_COLUMNS = {"energies": ["energy_EFFECT"], "works": ["work_EFFECT"]}
WHEEL_COLUMNS = {f"wheel{i}": [f"wheel{i}_{name}" for name in ("speed", "momentum", "motor_work", "friction_work")]
                 for i in range(1, 7)}
SPHERE_PARTS = ("rate1", "rate2", "rate3", "momentum_x", "momentum_y", "momentum_z", "energy", "friction_work")
SPHERE_COLUMNS = {f"sphere{i}": [f"sphere{i}_{name}" for name in SPHERE_PARTS] for i in range(1, 5)}
CONTROL_COLUMNS = {f"controller{i}": [f"controller{i}_{kind}{k}" for kind in ("commanded", "applied") for k in (1, 2, 3)]
                   + [f"controller{i}_saturations"] for i in range(1, 7)}
POINTING_COLUMNS = {f"pointing_error{i}": [f"pointing_error{i}"] for i in range(1, 7)}
FIELD_COLUMNS = {"magnetic_field": ["B1", "B2", "B3"]}
TUMBLING_COLUMNS = {"tumbling": ["energy_ratio", "short_axis_mode", "precession_period_short", "precession_period_long",
                                 "rotation_period", "pole_longitude", "pole_latitude", "sense"]}
FRAME_COLUMNS = {f"frame{i}": [f"frame{i}_{name}" for name in ("q0", "q1", "q2", "q3", "angle")] for i in range(1, 4)}
# The pattern of their names: they are those of the free numbers of a scene.
FREE_COLUMNS = {"sensitivities": ["d_COMPONENT/d_KEY"], "standard_deviations": ["sigma_COMPONENT"],
                "covariance": ["covariance_COMPONENT_COMPONENT"]}


def read_methods():
    """Rows of the table of methods: name, formulation, order, and whether its states are projected onto the invariants."""
    source = (ROOT / "src" / "methods" / "nutate_methods.f90").read_text(encoding="utf-8")
    return [(name, solver, order, "projected=.true." in rest)
            for name, solver, order, rest in re.findall(r"method_t\('(\w+)', *'(\w*)', *(\w+)(.*)", source)]


METHODS = read_methods()


def all_columns():
    """The value of output.columns that asks for every set, in an order that is not that of the file."""
    return ",".join(f"'{name}'" for name in reversed(COLUMNS))


def wait_until(true):
    """Waits until a condition holds, or as long as for a program that hangs."""
    for _ in range(int(PATIENCE/PAUSE)):
        if true():
            return
        time.sleep(PAUSE)
    raise AssertionError(f"nothing happened in {PATIENCE} s")


def is_asleep(run):
    """The program waits in a call of the system, or has ended."""
    with open(f"/proc/{run.pid}/stat", encoding="ascii", errors="replace") as stat:
        return stat.read().rpartition(")")[2].split()[0] in "SZ"


def chunks_done(path):
    """A number that grows with every chunk that a sweep writes to `path`.partial: marks in its map, or the time of the sums."""
    path += ".partial"
    if not os.path.exists(path):
        return 0
    if path.endswith(".csv.partial"):
        return os.stat(path).st_mtime_ns
    with open(path, "rb") as file:
        _, _, marks = file.read().rpartition(b"nutate sweep map 1\n")
    return marks[16:].count(b"x")


def one_of(attempts):
    """Repeats a test until it passes, so many times at most: for time limits of the program itself, such as the second that it
    gives a reader. A test that gets no processor in that second sees something else."""
    def decorate(test):
        @functools.wraps(test)
        def repeat(self):
            for attempt in range(attempts):
                if attempt:
                    self.doCleanups()
                    self.setUp()
                try:
                    return test(self)
                except AssertionError:
                    if attempt == attempts - 1:
                        raise
            return None
        return repeat
    return decorate


class CommandLineTest(unittest.TestCase):
    """Each test works in a folder of its own that holds box.nml and top.nml."""

    def setUp(self):
        self.heed_signals()
        self.program = os.environ["NUTATE"]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.write("box.nml", BOX)
        self.write("top.nml", TOP)

    def heed_signals(self):
        """What this process ignores, in the background of a script or under nohup, its children would ignore too."""
        for number, handler in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL),
                                (signal.SIGHUP, signal.SIG_DFL)):
            self.addCleanup(signal.signal, number, signal.signal(number, handler))

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def read(self, name):
        with open(self.path(name), encoding="utf-8", newline="") as file:
            return file.read()

    def names(self):
        return sorted(os.listdir(self.folder))

    def nutate(self, *arguments, **options):
        """Runs the program in the folder; its outcome with stdout and stderr as text."""
        return subprocess.run([self.program, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=PATIENCE, check=False, **options)

    def succeed(self, *arguments, **options):
        done = self.nutate(*arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def fail_with(self, status, *arguments, says=(), **options):
        """Runs what must fail: the status, and exactly one line on standard error, which holds all of `says`."""
        done = self.nutate(*arguments, **options)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertTrue(done.stderr.endswith("\n"))
        for text in says:
            self.assertIn(text.lower(), done.stderr.lower())
        return done

    def wait_for(self, name, size):
        """Waits until a file has grown to so many bytes."""
        wait_until(lambda: self.size(name) >= size)

    def size(self, name):
        """Bytes of a file; 0 if there is none."""
        path = self.path(name)
        return os.path.getsize(path) if os.path.exists(path) else 0

    def history(self, name):
        """Header and rows of numbers of a CSV file."""
        return parse(self.read(name))

    def find_in_noise(self, scene, truths, *options, sigma):
        """Fits parameters to rates of the body with noise: each must be found within four standard deviations. A key of several
        numbers has a list of them."""
        self.write("truth.nml", scene)
        self.succeed("run", "truth.nml", "--quiet", "--set", "output.columns='angular_velocity'", "--output", "truth.csv")
        header, rows = self.history("truth.csv")
        dice = random.Random(57)
        self.write("noise.csv", "\n".join([",".join(header)] + [",".join([repr(row[0])] + [repr(x + dice.gauss(0, sigma)) for x in row[1:]])
                                                               for row in rows]) + "\n")
        self.write("fit.nml", scene + f"&measurement file = 'noise.csv', sigma = {sigma}, columns = 'omega1', 'omega2', 'omega3' /\n"
                   + "".join(f"&free key = '{key}' /\n" for key in truths))
        page = self.succeed("fit", "fit.nml", *options).stdout
        for key, wanted in truths.items():
            wanted = wanted if isinstance(wanted, list) else [wanted]
            found = re.findall(rf"{re.escape(key)}\S* +(\S+) ± (\S+)", page)
            self.assertEqual(len(found), len(wanted), page)
            for (value, spread), truth in zip(found, wanted):
                self.assertLess(abs(float(value) - truth), 4 * float(spread), page)
                self.assertGreater(abs(float(value) - truth), 1e-3 * float(spread), page)
                self.assertLess(float(spread), 0.2 * abs(truth), page)


def parse(text):
    """Header and rows of numbers of CSV text."""
    rows = list(csv.reader(text.splitlines()))
    return rows[0], [[float(field) for field in row] for row in rows[1:]]

"""The columns 'energies' and 'works': one for each effect. Their sums are those of the set 'energy', in every row of every method."""
import os
import unittest

from support import METHODS, ROOT, CommandLineTest, in_turn
from test_sweep import read_npy

EPS = 2.0 ** -52

# Two of some kinds, wheels, a motor that stops inside a step, a potential and a torque that are switched.
SWITCHED = """&body inertia_tensor = 4.0, 5.0, 6.0, 0.5, -0.25, 0.75, mass = 2.0, center_of_mass = 0.3, -0.2, 0.5 /
&gravity acceleration = 0.5, 1.0, -9.0, name = 'weight' /
&spring body_point = 0.4, 0.1, -0.6, anchor = 0.5, 1.0, -0.8, stiffness = 5.0, rest_length = 0.7 /
&spring body_point = -0.4, 0.3, 0.6, anchor = -0.5, 1.0, 0.8, stiffness = 3.0, on = .false., name = 'band' /
&damping coefficient = 0.03, 0.01, 0.02 /
&torque space = 1.0, -0.4, 1.6, frequency = 0.7, phase = 0.4 /
&torque body = -1.5, 2.0, 1.0, start = 0.205, stop = 0.7, name = 'push' /
&wheel axis = 1, 2, 2, inertia = 0.05, speed = 3.0, torque = 0.2, start = 0, stop = 0.555 /
&wheel axis = 0, 3, 4, inertia = 0.02, speed = -40.0, friction = 0.01 /
&initial euler = 0.4, 1.1, -0.7, angular_velocity = 0.7, -1.1, 0.9 /
&integrator time_step = 0.02, end_time = 1.5 /
&event when = 'omega1', crosses = 1.0, switch = 'weight off' /
&event when = 'omega3', crosses = 0.8, switch = 'band on' /
&event when = 'omega2', crosses = -0.7, switch = 'push off' /
"""
SWITCHED_ENERGIES = ["energy_gravity", "energy_spring1", "energy_spring2"]
SWITCHED_WORKS = ["work_damping", "work_torque1", "work_torque2", "work_motor1", "work_friction1", "work_motor2",
                  "work_friction2", "work_switches"]

# Potentials that move with an eccentric orbit, and a controller that drives wheels.
MOVING = """&body inertia = 4.0, 5.0, 6.0 /
&orbit semi_major_axis = 1e7, eccentricity = 0.3, inclination = 60, raan = 30, degrees = .true. /
&gravity_gradient /
&earth_field moment = 200.0, -100.0, 50.0 /
&damping coefficient = 1e-4, 2e-4, 1e-4 /
&wheel axis = 1, 0, 0, inertia = 0.05, friction = 1e-4 /
&wheel axis = 0, 1, 0, inertia = 0.05 /
&wheel axis = 0, 0, 1, inertia = 0.05 /
&controller law = 'quaternion', by = 'wheels', attitude_gain = 1e-4, rate_gain = 1e-2, sample = 10.0 /
&initial axis = 1, 1, 1, angle = 0.7, angular_velocity = 0.01, -0.02, 0.01 /
&integrator time_step = 5.0, end_time = 300.0 /
"""
MOVING_WORKS = ["work_damping", "work_controller"] + [f"work_{name}{i}" for i in (1, 2, 3) for name in ("motor", "friction")]

# Rows at the ends of steps, between them at equal intervals, and at times of their own.
ROWS = {"time_step=": ("output.every=1", "output.times={times}"),
        "local_tolerance=": ("output.every=1", "output.interval={interval}", "output.times={times}")}


class EffectColumns(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("switched.nml", SWITCHED)
        self.write("moving.nml", MOVING)
        with open(os.path.join(ROOT, "scenes", "all_effects.nml"), encoding="utf-8") as file:
            self.write("all_effects.nml", file.read().replace("end_time = 20.0", "end_time = 3.0"))

    def rows(self, scene, *settings, name="rows.csv"):
        arguments = [part for setting in settings for part in ("--set", setting)]
        self.succeed("run", scene, "--quiet", "--output", name, *arguments)
        header, rows = self.history(name)
        return [dict(zip(header, row)) for row in rows]

    def assess(self, rows, first, closes, wheels=0):
        """Energies are those of the potentials, works those of the sums; where `closes`, they explain the change of the energy."""
        potentials = [key for key in rows[0] if key.startswith("energy_") and key != "energy_residual"]
        parts = [key for key in rows[0] if key.startswith("work_")]
        size = max(row["kinetic"] + sum(abs(row[key]) for key in (*potentials, "energy_residual", "work", *parts)) for row in rows)
        for row in rows:
            energies = sum(row[key] for key in potentials)
            works = sum(row[key] for key in parts)
            self.assertLess(abs(energies - row["potential"]), 4 * EPS * size)
            # Sums of up to some hundred steps, each rounded.
            self.assertLess(abs(works - row["work"] - row["time_dependent_work"]), 100 * EPS * size)
            if "work_time_dependent" in row:
                self.assertLess(abs(row["work_time_dependent"] - row["time_dependent_work"]), 100 * EPS * size)
            for i in range(1, wheels + 1):
                for name in ("motor", "friction"):
                    self.assertLess(abs(row[f"work_{name}{i}"] - row[f"wheel{i}_{name}_work"]), 100 * EPS * size)
            change = row["total"] - first["total"] - works
            self.assertLess(abs(change - row["energy_residual"]), 100 * EPS * size)
            if closes:
                self.assertLess(abs(change), 1000 * EPS * size)

    def methods(self):
        for name, solver, order, projected in METHODS:
            if name == "exact":
                continue
            settings = [f"integrator.method='{name}'"]
            if solver:
                settings += [f"integrator.formulation='{solver}'", f"integrator.order={order}"]
            yield settings, name == "nielsen_krenk"
            if projected:
                yield settings + ["integrator.conserve=.true."], True

    def test_sums_close_in_every_row_of_every_method(self):
        scenes = {"all_effects.nml": (0.02, 3.0, 0, ""), "switched.nml": (0.02, 1.5, 2, ",wheel1,wheel2"),
                  "moving.nml": (5.0, 300.0, 3, ",wheel1,wheel2,wheel3")}
        for scene, (step, end, wheels, sets) in scenes.items():
            columns = f"output.columns=energy,time_dependent_work{sets},energies,works"
            times = ",".join(repr(end * part) for part in (0.0, 0.00123, 0.0133, 0.137, 0.36, 0.37, 0.5, 0.777, 0.99, 1.0))
            for number, (settings, closes) in enumerate(self.methods(), len(scene)):
                if not in_turn(number):
                    continue
                for length, plans in ROWS.items():
                    goal = f"integrator.{length}{step if length == 'time_step=' else 1e-6}"
                    for plan in plans:
                        with self.subTest(scene=scene, method=settings, goal=goal, plan=plan):
                            rows = self.rows(scene, columns, *settings, goal, plan.format(times=times, interval=end / 41))
                            self.assertGreater(len(rows), 4)
                            self.assertEqual(rows[0]["t"], 0.0)
                            self.assess(rows, rows[0], closes, wheels)

    def test_columns_have_their_names(self):
        self.succeed("run", "switched.nml", "--quiet", "--set", "output.columns=works,energies,solver", "--output", "a.csv")
        header, rows = self.history("a.csv")
        self.assertEqual(header, ["t", "iterations", "step_residual"] + SWITCHED_ENERGIES + SWITCHED_WORKS)
        self.assertEqual(rows[0][-8:], [0.0] * 8)
        for i in range(3, len(header)):
            if header[i] not in ("work_motor2", "work_friction1"):
                self.assertGreater(max(abs(row[i]) for row in rows), 1e-3, header[i])
        self.succeed("run", "moving.nml", "--quiet", "--set", "output.columns=energies,works", "--output", "b.csv")
        self.assertEqual(self.history("b.csv")[0], ["t", "energy_gravity_gradient", "energy_earth_field"] + MOVING_WORKS
                         + ["work_time_dependent"])
        self.assertIn("energy_gravity,energy_spring1,energy_spring2,work_damping", self.succeed(
            "check", "switched.nml", "--set", "output.columns=energies,works").stdout)

    def test_a_potential_that_is_off_has_no_energy(self):
        rows = self.rows("switched.nml", "output.columns=energy,energies,works")
        self.assertEqual(rows[0]["energy_spring2"], 0.0)
        self.assertEqual(rows[0]["potential"], rows[0]["energy_gravity"] + rows[0]["energy_spring1"])
        self.assertTrue(any(row["energy_gravity"] == 0.0 for row in rows))

    def test_the_last_row_has_the_works_of_the_summary(self):
        done = self.succeed("run", "switched.nml", "--set", "output.columns=works", "--output", "a.csv")
        header, rows = self.history("a.csv")
        for name, value in zip(header[1:], rows[-1][1:]):
            name = name.replace("work_", "").replace("1", " 1").replace("2", " 2").replace("torque 2", "torque 'push'")
            line, = (line for line in done.stderr.splitlines() if line.strip().startswith(f"work of {name} "))
            self.assertAlmostEqual(float(line.split(f"work of {name} ")[1].split()[0]), value, delta=1e-5 * abs(value) + 1e-300)

    def test_rows_of_events_have_them(self):
        for number, (settings, closes) in enumerate(self.methods()):
            if not in_turn(number):
                continue
            for goal in ("time_step=0.02", "local_tolerance=1e-6"):
                with self.subTest(method=settings, goal=goal):
                    first = self.rows("switched.nml", "output.columns=energy,time_dependent_work,wheel1,wheel2,energies,works",
                                      f"integrator.{goal}", *settings)[0]
                    header, *lines = self.read("rows.events.csv").splitlines()
                    rows = [dict(zip(header.split(","), line.split(","))) for line in lines]
                    self.assertGreater(len(rows), 2)
                    self.assess([{key: float(value) for key, value in row.items() if key not in ("event", "number")} for row in rows],
                               first, closes, 2)

    def test_works_count_backward_too(self):
        for method in ("nielsen_krenk", "rk8", "taylor"):
            rows = self.rows("all_effects.nml", f"integrator.method={method}", "integrator.time_step=-0.02", "integrator.end_time=-1.0",
                             "output.columns=energy,time_dependent_work,energies,works")
            self.assess(rows, rows[0], method != "rk8")

    def test_members_have_them(self):
        scene = SWITCHED + """&output columns = 'energy', 'energies', 'works' /
&ensemble members = 5, seed = 1, file = 'members.npy' /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.1, 0.1, 0.1 /
"""
        self.write("members.nml", scene)
        self.succeed("sweep", "members.nml")
        with open(self.path("members.npy"), "rb") as file:
            names, members = read_npy(file.read())
        self.assertEqual([name for name in names if name.startswith("work_")], SWITCHED_WORKS)
        for number, member in enumerate(members, 1):
            self.succeed("sweep", "members.nml", "--quiet", "--member", str(number), "--output", "one.csv")
            header, rows = self.history("one.csv")
            values = dict(zip(names, member))
            self.assertEqual([values[name] for name in header], rows[-1])

    def test_scenes_without_such_effects_refuse_them(self):
        self.fail_with(2, "run", "box.nml", "--set", "output.columns=energies", says=["energies", "&gravity"])
        self.fail_with(2, "run", "top.nml", "--set", "output.columns=works", says=["works", "&torque"])
        self.fail_with(2, "run", "top.nml", "--set", "output.columns=energy,works", says=["works", "&torque"])

    def test_events_refuse_them(self):
        self.write("event.nml", SWITCHED + "&event when = 'energy_gravity', crosses = 1.0 /\n")
        self.fail_with(2, "run", "event.nml", says=["event.nml:15", "energy_gravity"])


if __name__ == "__main__":
    unittest.main()

"""nutate run --checkpoint and --resume: what goes on is byte for byte what it would have been, or is refused."""
import os
import random
import re
import subprocess
import unittest

from support import PATIENCE, CommandLineTest, all_columns, in_turn, wait_until

# Torques that start and stop inside steps, a spring and damping: everything that a step can remember.
FORCED = """&body inertia = 2.0, 3.0, 4.0, mass = 1.0, center_of_mass = 0.1, 0.0, 0.3 /
&initial axis = 1.0, 2.0, 0.5, angle = 0.7, angular_velocity = 1.0, -2.0, 6.0 /
&gravity /
&spring body_point = 0.0, 0.5, 0.0, anchor = 1.0, 1.0, 0.0, stiffness = 30.0, rest_length = 0.2 /
&damping coefficient = 0.05, 0.1, 0.02 /
&torque body = 1.0, 0.0, -2.0, frequency = 0.7, start = 0.1234, stop = 0.3711 /
&torque space = 0.0, 1.5, 0.5, start = 0.25 /
&integrator time_step = 0.01, end_time = 0.6 /
"""

# What happens in it: crossings, an extremum, a potential and a torque that are switched.
EVENTS = """&event when = 'omega1', crosses = 2.0, switch = 'weight toggle' /
&event when = 'omega3', crosses = 5.0, switch = 'drag on' /
&event name = 'over', when = 'q0', crosses = 0.2, switch = 'weight toggle' /
&event name = 'turn', when = 'psi', extremum = 'both' /
&event when = 'omega2', crosses = 0.0 /
&event when = 'q0', crosses = 0.0 /
&event when = 'psi', crosses = 1.0 /
"""

# Lines of a table inside steps, with a jump, again and again.
TABLE = """t (s),x (N m),y (N m),z (N m)
0,1,0,-2
0.0731,2,0.5,1
0.0731,-1,0.5,1
0.1117,0.5,0,3
0.1903,0,1,0.5
"""
TABULATED = FORCED.replace("&torque space = 0.0, 1.5, 0.5, start = 0.25 /",
                           "&torque table = 'table.csv', outside = 'periodic', axes = 'space', start = 0.05, stop = 0.5 /")

# Inertia by a table, with lines inside steps.
INERTIA = """t (s),J11 (kg m2),J22 (kg m2),J33 (kg m2)
0,5,20,17
0.0731,5.1,19,16
0.1117,5.2,18,15.5
0.5,5.5,17,15
"""
CENTER = """t (s),x (m),y (m),z (m)
0,0.1,0,0.2
0.0731,0.2,0,0.3
0.5,0.2,0.1,0.1
"""
LEANING = """&body inertia_table = 'inertia.csv', mass = 2, center_of_mass_table = 'center.csv' /
&gravity /
&gravity_gradient direction = 1, 2, 3, strength = 2 /
&initial angular_velocity = 3, 1, 5 /
&integrator time_step = 0.01, end_time = 0.4 /
&output columns = 'quaternion', 'energy', 'works' /
"""
GROWING = """&body inertia_table = 'inertia.csv', inertia_interpolation = 'cubic' /
&inertia_rate tensor = 3*-0.5, start = 0.05, stop = 0.3, mass_leaves = .true. /
&initial angular_velocity = 3, 1, 5 /
&integrator time_step = 0.01, end_time = 0.4 /
&output columns = 'quaternion', 'energy', 'works' /
"""

CONSERVING = [("nielsen_krenk", solver, order) for solver in ("full", "reduced") for order in (2, 4, 6, 8)]
EXPLICIT = [("rk4", None, None), ("rk8", None, None), ("dop853", None, None)]


def some_methods(shift, *more):
    """Every method, or one in three where tests take turns; others for each shift."""
    return [method for number, method in enumerate([*CONSERVING, *EXPLICIT, *more], shift) if in_turn(number)]


def some_limits(shift, *limits):
    """All numbers of steps, or one in three where tests take turns, at least one; others for each shift."""
    return [limit for number, limit in enumerate(limits, shift % 3) if in_turn(number)]


def method_settings(method, solver, order):
    settings = ["--set", f"integrator.method='{method}'"]
    if solver:
        settings += ["--set", f"integrator.formulation='{solver}'", "--set", f"integrator.order={order}"]
    return settings


def without_times(summary):
    """A summary without what differs from run to run, what a run says at its start, and the name of the history."""
    return re.sub(r" +(wall time|time per step|history|events) .*\n|.* to expect\n", "", summary)


class CheckpointTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("forced.nml", FORCED)

    def controlled(self, scene, key, value):
        """A scene with adaptive steps."""
        self.write("controlled.nml", self.read(scene).replace("time_step = 0.01", f"{key} = {value}"))
        return "controlled.nml"

    def interrupt(self, scene, limit, *settings):
        self.fail_with(3, "run", scene, "--output", "part.csv", "--checkpoint", "ck", "--max-steps", str(limit),
                       *settings, says=["to continue: --resume ck"])

    def kill_later(self, moments, *arguments):
        """Kills a run of forced.nml when its rows have grown by a random number of bytes, or when it has ended."""
        target = self.size("part.csv.partial") + moments.randrange(40000)
        command = [self.program, "run", "forced.nml", "--quiet", "--every-seconds", "0", *arguments]
        with subprocess.Popen(command, cwd=self.folder) as run:
            wait_until(lambda: self.size("part.csv.partial") >= target or run.poll() is not None)
            run.kill()

    def resumes_exactly(self, scene, limits, *settings):
        """Interrupted at each number of steps, the history and the summary are those of the whole run."""
        whole = self.succeed("run", scene, "--output", "whole.csv", *settings)
        for limit in limits:
            self.interrupt(scene, limit, *settings)
            done = self.succeed("run", scene, "--resume", "ck", *settings)
            self.assertEqual(self.read("part.csv"), self.read("whole.csv"), f"{settings} at {limit}")
            self.assertEqual(without_times(done.stderr), without_times(whole.stderr))
            self.assertNotIn("ck", self.names())


class Resumed(CheckpointTest):
    def test_every_method_with_fixed_steps(self):
        for turn, method in enumerate(some_methods(0)):
            self.resumes_exactly("forced.nml", some_limits(turn, 1, 14, 41), *method_settings(*method), "--set",
                                 f"output.columns={all_columns()},'energies','works'")

    def test_every_method_with_steps_by_their_error(self):
        scene = self.controlled("forced.nml", "local_tolerance", "1e-6")
        for method in some_methods(1):
            self.resumes_exactly(scene, (3,), *method_settings(*method), "--set", f"output.columns={all_columns()},'energies','works'",
                                 "--set", "output.interval=0.007")

    def test_sums_of_the_series_and_their_compensation(self):
        self.write("satellite.nml", "&body inertia = 100.0, 90.0, 40.0 /\n&orbit semi_major_axis = 6878137.0 /\n"
                   "&gravity_gradient /\n&initial roll_pitch_yaw = 0.1, 0.2, 0.3, angular_velocity = 1e-4, 0.0, 2e-4 /\n"
                   "&integrator method = 'taylor', time_step = 50.0, end_time = 3000.0 /\n&output every = 3 /\n")
        self.resumes_exactly("satellite.nml", (1, 2, 3, 7, 41), "--set", f"output.columns={all_columns()}")

    def test_steps_in_the_lvlh_frame(self):
        self.write("satellite.nml", "&body inertia = 100.0, 90.0, 40.0 /\n&orbit semi_major_axis = 6878137.0, inclination = 1.0 /\n"
                   "&gravity_gradient /\n&wheel axis = 0, 1, 0, inertia = 0.05, torque = 1e-6, speed = 1.0 /\n"
                   "&initial roll_pitch_yaw = 0.1, 0.2, 0.3, angular_velocity = 1e-4, 0.0, 2e-4 /\n"
                   "&integrator time_step = 50.0, end_time = 3000.0 /\n&event when = 'q0', extremum = 'both' /\n")
        columns = "output.columns='quaternion','energy','works','lvlh_attitude','solver'"
        for turn, method in enumerate(some_methods(2)):
            self.resumes_exactly("satellite.nml", some_limits(turn, 1, 14, 41), *method_settings(*method), "--set", columns)
            self.resumes_exactly("satellite.nml", (1, 5), *method_settings(*method), "--set", columns, "--set", "output.interval=70",
                                 "--unset", "integrator.time_step", "--set", "integrator.local_tolerance=1e-9")

    def test_events_and_switches(self):
        self.write("forced.nml", FORCED.replace("&gravity", "&gravity name = 'weight'").replace(
            "coefficient = 0.05", "name = 'drag', on = .false., coefficient = 0.05") + EVENTS)
        for turn, method in enumerate([*CONSERVING[:2], *EXPLICIT, ("taylor", None, None)]):
            self.resumes_exactly("forced.nml", some_limits(turn, 1, 9, 33, 60), *method_settings(*method), "--set", "output.columns=energies,works")
            self.assertEqual(self.read("part.events.csv"), self.read("whole.events.csv"), method)
        self.assertGreater(self.read("whole.events.csv").count("\n"), 6)

    def test_events_and_switches_with_steps_by_their_error(self):
        self.write("forced.nml", FORCED.replace("&gravity", "&gravity name = 'weight'").replace(
            "coefficient = 0.05", "name = 'drag', on = .false., coefficient = 0.05") + EVENTS)
        scene = self.controlled("forced.nml", "local_tolerance", "1e-6")
        for method in [CONSERVING[0], *EXPLICIT, ("taylor", None, None)]:
            self.resumes_exactly(scene, (4,), *method_settings(*method), "--set", "output.interval=0.007")
            self.assertEqual(self.read("part.events.csv"), self.read("whole.events.csv"), method)

    def test_a_limit_of_speed_with_projected_steps(self):
        """The steps that look for the limit are projected like the others."""
        self.write("wheel.nml", "&body inertia = 1.0, 1.2, 1.4 /\n&initial angular_velocity = 0.3, 1.2, 0.5 /\n"
                   "&wheel axis = 1.0, 0.3, 0.2, inertia = 0.1, speed = 1.0, speed_limit = 1.5, torque = 0.1, friction = 0.02 /\n"
                   "&integrator conserve = .true., local_tolerance = 1e-10, end_time = 3.0 /\n&output columns = 'wheel1', interval = 0.1 /\n")
        for method in EXPLICIT:
            self.resumes_exactly("wheel.nml", (4, 5, 9, 14), *method_settings(*method))

    def test_events_that_cannot_happen_for_many_steps(self):
        """A torque drives a rate to its value: until near there nothing is looked for."""
        self.write("drive.nml", FORCED.replace("&gravity /", "").replace("anchor = 1.0, 1.0, 0.0, stiffness = 30.0",
                   "anchor = 1.0, 1.0, 0.0, stiffness = 0.1").replace("end_time = 0.6", "end_time = 3") + "&torque name = 'drive', "
                   "body = 0, 0, 30 /\n&event when = 'omega3', crosses = 25, direction = 1, count = 2 /\n"
                   "&event when = 'omega3', crosses = 24.9, switch = 'drive off' /\n")
        for turn, method in enumerate([*CONSERVING[4:6], ("rk4", None, None), ("taylor", None, None)]):
            self.resumes_exactly("drive.nml", some_limits(turn, 5, 60, 170, 280), *method_settings(*method))
            self.assertEqual(self.read("part.events.csv"), self.read("whole.events.csv"), method)
            self.assertGreaterEqual(self.read("whole.events.csv").count("\n"), 2)

    def test_killed_between_events_and_switches(self):
        moments = random.Random(7)
        self.write("forced.nml", FORCED.replace("&gravity", "&gravity name = 'weight'").replace(
            "coefficient = 0.05", "name = 'drag', on = .false., coefficient = 0.05") + EVENTS)
        settings = ("--set", "integrator.end_time=25", "--set", "integrator.time_step=0.005", "--set",
                    "output.columns='euler','energy'")
        self.succeed("run", "forced.nml", "--output", "whole.csv", "--quiet", *settings)
        arguments = ["--output", "part.csv", "--checkpoint", "ck"]
        for _ in range(8):
            self.kill_later(moments, *arguments, *settings)
            if "part.csv" in self.names():
                break
            if "ck" in self.names():
                arguments = ["--resume", "ck"]
        if "part.csv" not in self.names():
            self.succeed("run", "forced.nml", "--quiet", *arguments, *settings)
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        self.assertEqual(self.read("part.events.csv"), self.read("whole.events.csv"))

    def test_every_method_with_a_table(self):
        self.write("table.csv", TABLE)
        self.write("tabulated.nml", TABULATED)
        for method in some_methods(1, ("taylor", None, None)):
            self.resumes_exactly("tabulated.nml", (7, 14), *method_settings(*method))
        scene = self.controlled("tabulated.nml", "local_tolerance", "1e-6")
        for method in (("nielsen_krenk", "reduced", 4), ("dop853", None, None), ("taylor", None, None)):
            self.resumes_exactly(scene, (3, 9), *method_settings(*method), "--set", "output.interval=0.007")

    def test_another_table_is_another_scene(self):
        self.write("table.csv", TABLE)
        self.write("tabulated.nml", TABULATED)
        self.interrupt("tabulated.nml", 14)
        self.write("table.csv", TABLE.replace("0.5,0,3", "0.5,0,3.0"))
        self.fail_with(2, "run", "tabulated.nml", "--resume", "ck", says=["another scene (&torque is not the same)"])
        self.write("table.csv", TABLE)
        self.succeed("run", "tabulated.nml", "--resume", "ck")

    def test_an_inertia_by_a_table(self):
        self.write("inertia.csv", INERTIA)
        self.write("growing.nml", GROWING)
        for method in some_methods(0, ("taylor", None, None)):
            self.resumes_exactly("growing.nml", (7, 14), *method_settings(*method))
        self.interrupt("growing.nml", 14)
        self.write("inertia.csv", INERTIA.replace("5.5,17", "5.5,17.0"))
        self.fail_with(2, "run", "growing.nml", "--resume", "ck", says=["another scene (&body is not the same)"])

    def test_a_centre_of_mass_by_a_table(self):
        self.write("inertia.csv", INERTIA)
        self.write("center.csv", CENTER)
        self.write("leaning.nml", LEANING)
        for method in some_methods(2, ("taylor", None, None)):
            self.resumes_exactly("leaning.nml", (7, 14), *method_settings(*method))
        self.interrupt("leaning.nml", 14)
        self.write("center.csv", CENTER.replace("0.1,0,0.2", "0.1,0,0.20"))
        self.fail_with(2, "run", "leaning.nml", "--resume", "ck", says=["another scene (&body is not the same)"])
        self.write("center.csv", CENTER)
        self.succeed("run", "leaning.nml", "--resume", "ck")

    def test_the_exact_motion(self):
        self.resumes_exactly("box.nml", (1, 20), "--set", "integrator.method='exact'")

    def test_an_accuracy_found_by_trial_runs(self):
        scene = self.controlled("forced.nml", "accuracy", "1e-5")
        settings = ("--set", "integrator.formulation='reduced'", "--set", "integrator.order=4", "--set",
                    "integrator.end_time=4", "--set", "output.interval=0.0003")
        whole = self.succeed("run", scene, "--output", "whole.csv", *settings)
        command = [self.program, "run", scene, "--output", "part.csv", "--checkpoint", "ck", "--quiet", *settings]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE) as run:
            self.wait_for("part.csv.partial", 100000)
            run.terminate()
            self.assertIn(b"to continue: --resume ck", run.stderr.read())
        done = self.succeed("run", scene, "--resume", "ck", *settings)
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        self.assertEqual(without_times(done.stderr), without_times(whole.stderr))

    def test_rare_rows_and_angles_that_are_followed(self):
        self.resumes_exactly("forced.nml", (13, 29), "--set", "output.columns='euler','solver'", "--set", "output.every=7")

    def test_subdivided_steps(self):
        self.resumes_exactly("box.nml", (1, 5, 11), "--set", "integrator.time_step=0.3", "--set", "integrator.end_time=9")

    def test_backwards_without_attitude_and_with_a_finite_auxiliary_inertia(self):
        self.resumes_exactly("forced.nml", (7,), "--set", "integrator.time_step=-0.01", "--set", "integrator.end_time=-0.4")
        self.resumes_exactly("box.nml", (7,), "--set", "output.columns='angular_velocity'")
        self.resumes_exactly("forced.nml", (7,), "--set", "integrator.auxiliary_inertia=5.0")

    def test_interrupted_again_and_again(self):
        self.succeed("run", "forced.nml", "--output", "whole.csv")
        self.interrupt("forced.nml", 5)
        for limit in range(10, 60, 5):
            self.fail_with(3, "run", "forced.nml", "--resume", "ck", "--max-steps", str(limit), says=["--resume ck"])
        self.succeed("run", "forced.nml", "--resume", "ck")
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_checkpoints_can_go_on_in_another_file(self):
        self.succeed("run", "forced.nml", "--output", "whole.csv")
        self.interrupt("forced.nml", 5)
        self.fail_with(3, "run", "forced.nml", "--resume", "ck", "--checkpoint", "other", "--max-steps", "20",
                       says=["--resume other"])
        self.succeed("run", "forced.nml", "--resume", "other")
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        self.assertNotIn("other", self.names())
        # The first one is left alone, and of no use any more.
        self.fail_with(2, "run", "forced.nml", "--resume", "ck", says=["part.csv.partial", "no such file"])

    def test_quiet_runs_can_be_resumed_with_their_summary(self):
        whole = self.succeed("run", "forced.nml", "--output", "whole.csv")
        self.interrupt("forced.nml", 30, "--quiet")
        done = self.succeed("run", "forced.nml", "--resume", "ck")
        self.assertEqual(without_times(done.stderr), without_times(whole.stderr))

    def test_what_was_written_after_the_checkpoint_is_cut_off(self):
        self.succeed("run", "forced.nml", "--output", "whole.csv")
        self.interrupt("forced.nml", 30)
        with open(self.path("part.csv.partial"), "a", encoding="utf-8") as partial:
            partial.write("0.31,1,2,3\nhalf a li")
        self.succeed("run", "forced.nml", "--resume", "ck")
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_killed_at_random_moments(self):
        moments = random.Random(5)
        settings = ("--set", "integrator.end_time=60", "--set", "integrator.time_step=0.005", "--set",
                    "output.columns='euler','energy','solver'")
        self.succeed("run", "forced.nml", "--output", "whole.csv", "--quiet", *settings)
        arguments = ["--output", "part.csv", "--checkpoint", "ck"]
        for _ in range(12):
            self.kill_later(moments, *arguments, *settings)
            if "part.csv" in self.names():
                break
            if "ck" in self.names():
                arguments = ["--resume", "ck"]
        if "part.csv" not in self.names():
            self.succeed("run", "forced.nml", "--quiet", *arguments, *settings)
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_killed_after_a_checkpoint_far_into_the_run(self):
        """Killed at the first checkpoint that follows a growth of the rows: resumed in mid-run for certain."""
        settings = ("--set", "integrator.end_time=60", "--set", "integrator.time_step=0.002")
        self.succeed("run", "forced.nml", "--output", "whole.csv", "--quiet", *settings)
        command = [self.program, "run", "forced.nml", "--quiet", "--every-seconds", "0", "--output", "part.csv",
                   "--checkpoint", "ck", *settings]
        with subprocess.Popen(command, cwd=self.folder) as run:
            self.wait_for("part.csv.partial", 600000)
            run.kill()
        self.assertIn("ck", self.names())
        self.succeed("run", "forced.nml", "--quiet", "--resume", "ck", *settings)
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))


class Refused(CheckpointTest):
    def setUp(self):
        super().setUp()
        self.interrupt("forced.nml", 30)
        self.kept = {name: self.bytes_of(name) for name in ("ck", "part.csv.partial")}

    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def put(self, name, content):
        with open(self.path(name), "wb") as file:
            file.write(content)

    def refused(self, *arguments, says, scene="forced.nml"):
        """One line, status 2, and no file is another one than before."""
        before = {name: self.bytes_of(name) for name in self.names()}
        self.fail_with(2, "run", scene, *arguments, says=says)
        self.assertEqual({name: self.bytes_of(name) for name in self.names()}, before)

    def test_another_scene(self):
        self.refused("--resume", "ck", "--set", "integrator.time_step=0.02", says=["ck", "another scene", "&integrator"])
        self.refused("--resume", "ck", "--set", "gravity.acceleration=0,0,-1", says=["another scene", "&gravity"])
        self.refused("--resume", "ck", scene="box.nml", says=["another scene"])

    def test_a_scene_that_only_looks_different_is_the_same(self):
        self.write("forced.nml", "! A comment.\n\n" + FORCED.replace(", ", " ,   ").replace("/\n", "\n/\n"))
        self.succeed("run", "forced.nml", "--resume", "ck")

    def test_no_checkpoint(self):
        self.refused("--resume", "nowhere", says=["nowhere", "no such file"])
        self.refused("--resume", "forced.nml", says=["forced.nml", "not a checkpoint"])
        self.put("empty", b"")
        self.refused("--resume", "empty", says=["empty", "not a checkpoint"])
        os.mkdir(self.path("folder"))
        self.fail_with(2, "run", "forced.nml", "--resume", "folder", says=["folder"])

    def test_a_checkpoint_cut_short_anywhere(self):
        content = self.kept["ck"]
        for length in [*filter(in_turn, range(40)), len(content) // 2, len(content) - 8, len(content) - 1]:
            self.put("ck", content[:length])
            self.refused("--resume", "ck", says=["ck"])
        self.put("ck", content + b"x")
        self.refused("--resume", "ck", says=["damaged"])

    def test_a_flipped_bit(self):
        content = self.kept["ck"]
        for i in filter(in_turn, [*range(20, 36), *random.Random(1).sample(range(36, len(content)), 40)]):
            self.put("ck", content[:i] + bytes([content[i] ^ 1 << i % 8]) + content[i + 1:])
            self.refused("--resume", "ck", says=["damaged"])

    def test_another_format(self):
        for number in b"1", b"2", b"10":
            self.put("ck", self.kept["ck"].replace(b"checkpoint 3", b"checkpoint " + number))
            self.refused("--resume", "ck", says=["ck", "was written by another version of nutate"])
        self.put("ck", self.kept["ck"].replace(b"nutate checkpoint 3", b"another document 3"))
        self.refused("--resume", "ck", says=["not a checkpoint"])

    def test_rows_that_are_gone_or_not_the_same(self):
        rows = self.kept["part.csv.partial"]
        os.remove(self.path("part.csv.partial"))
        self.refused("--resume", "ck", says=["part.csv.partial", "no such file"])
        self.put("part.csv.partial", rows[:-1])
        self.refused("--resume", "ck", says=["part.csv.partial", "fewer"])
        self.put("part.csv.partial", rows[:-3] + b"5" + rows[-2:])
        if self.bytes_of("part.csv.partial") == rows:
            self.put("part.csv.partial", rows[:-3] + b"6" + rows[-2:])
        self.refused("--resume", "ck", says=["part.csv.partial", "have changed"])

    def test_events_that_are_not_the_same_are_named_by_their_partial_file(self):
        events = ("--set", "event.when=omega1", "--set", "event.extremum=both", "--output", "box.csv")
        self.fail_with(3, "run", "box.nml", *events, "--checkpoint", "events.ck", "--max-steps", "40", "--quiet")
        with open(self.path("box.events.csv.partial"), "r+b") as partial:
            partial.write(b"T")
        self.fail_with(2, "run", "box.nml", *events, "--resume", "events.ck",
                       says=["events.ck cannot be resumed: box.events.csv.partial: its rows have changed"])

    def test_another_output(self):
        self.refused("--resume", "ck", "--output", "other.csv", says=["part.csv", "--output"])
        self.succeed("run", "forced.nml", "--resume", "ck", "--output", "part.csv")

    def test_a_checkpoint_is_not_written_over(self):
        self.refused("--checkpoint", "ck", "--output", "part.csv", says=["ck", "--resume"])
        self.refused("--checkpoint", "forced.nml", says=["forced.nml"])
        self.refused("--checkpoint", "part.csv.partial", "--output", "part.csv", says=["part.csv.partial"])

    def test_names_that_clash(self):
        self.refused("--checkpoint", "x.csv", "--output", "x.csv", says=["x.csv is where the rows go"])
        self.refused("--checkpoint", "c", "--output", "-", says=["--checkpoint", "file"])
        self.refused("--checkpoint", "c", "--output", "/dev/null", says=["--checkpoint", "file"])

    def test_arguments(self):
        self.refused("--every-seconds", "3", says=["--every-seconds", "--checkpoint"])
        self.refused("--checkpoint", "", says=["--checkpoint"])
        self.refused("--resume", "", says=["--resume"])
        for value in ("-1", "often", "nan", ""):
            self.refused("--checkpoint", "c", "--every-seconds", value, says=["--every-seconds"])

    def test_a_run_that_is_still_writing(self):
        command = [self.program, "run", "forced.nml", "--quiet", "--output", "long.csv", "--checkpoint", "live",
                   "--every-seconds", "0", "--set", "integrator.end_time=1e6", "--set", "output.every=1"]
        with subprocess.Popen(command, cwd=self.folder) as run:
            self.wait_for("long.csv.partial", 200000)
            self.fail_with(2, "run", "forced.nml", "--resume", "live", "--set", "integrator.end_time=1e6", "--set", "output.every=1",
                           says=["another run"])
            run.kill()


class CheckpointFiles(CheckpointTest):
    def test_another_name_of_where_the_rows_go(self):
        self.fail_with(2, "run", "forced.nml", "--output", "x.csv", "--checkpoint", "./x.csv",
                       says=["./x.csv", "where the rows go"])
        self.assertNotIn("x.csv", self.names())

    def test_a_folder_that_is_not_there(self):
        self.fail_with(4, "run", "forced.nml", "--checkpoint", "nowhere/ck", says=["nowhere/ck", "no such file"])
        self.assertNotIn("forced.csv", self.names())

    @unittest.skipIf(os.geteuid() == 0, "root writes everywhere")
    def test_a_folder_that_must_not_be_written(self):
        os.mkdir(self.path("closed"), 0o555)
        self.fail_with(4, "run", "forced.nml", "--checkpoint", "closed/ck", says=["closed/ck", "permission"])

    def test_a_folder_that_vanishes_ends_the_run_with_its_rows(self):
        os.mkdir(self.path("gone"))
        command = [self.program, "run", "forced.nml", "--quiet", "--checkpoint", "gone/ck", "--every-seconds", "0", "--set",
                   "integrator.end_time=1e6", "--set", "output.every=1"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
            self.wait_for("forced.csv.partial", 200000)
            os.rename(self.path("gone"), self.path("elsewhere"))
            _, said = run.communicate(timeout=PATIENCE)
        self.assertEqual(run.returncode, 4)
        self.assertEqual(said.count("\n"), 1)
        self.assertIn("cannot write checkpoint gone/ck", said)
        self.assertIn("forced.csv.partial", said)
        # The last checkpoint is still good.
        self.fail_with(3, "run", "forced.nml", "--resume", "elsewhere/ck", "--set", "integrator.end_time=1e6", "--set", "output.every=1",
                       "--max-steps", "1")
        self.assertEqual([name for name in os.listdir(self.path("elsewhere")) if name != "ck"], [])

    def test_nothing_is_left_of_a_complete_run_but_its_rows(self):
        self.succeed("run", "forced.nml", "--checkpoint", "ck", "--every-seconds", "0")
        self.assertEqual(self.names(), ["box.nml", "forced.csv", "forced.nml", "top.nml"])

    def test_checkpoints_do_not_change_the_rows(self):
        self.succeed("run", "forced.nml", "--output", "plain.csv")
        self.succeed("run", "forced.nml", "--checkpoint", "ck", "--every-seconds", "0")
        self.assertEqual(self.read("plain.csv"), self.read("forced.csv"))


if __name__ == "__main__":
    unittest.main()

"""nutate sweep: one row for each member, the same bytes whatever way they came about."""
import math
import os
import random
import re
import signal
import struct
import subprocess
import unittest

from support import ONE_IN, PATIENCE, CommandLineTest, chunks_done, wait_until

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
TUMBLE = """&scene title = 'Tumble' /
&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&integrator formulation = 'reduced', time_step = 0.01, end_time = 0.5 /
&output columns = 'quaternion', 'angular_velocity', 'energy', every = 10 /
&event name = 'flip', when = 'q0', crosses = 0.0 /
&ensemble members = 200, seed = 1, file = 'tumble.npy' /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 0.01, 0.5 /
&vary key = 'body.inertia', distribution = 'uniform', low = 4.9, 19.6, 16.7, high = 5.1, 20.4, 17.3 /
&vary key = 'initial.quaternion', distribution = 'rotation' /
"""

# For loops of sweeps whose members do not matter.
FEW = ("--set", "ensemble.members=60")
VARIED = ["initial.angular_velocity.1", "initial.angular_velocity.2", "initial.angular_velocity.3", "body.inertia.1",
          "body.inertia.2", "body.inertia.3", "initial.quaternion.1", "initial.quaternion.2", "initial.quaternion.3",
          "initial.quaternion.4"]
COLUMNS = ["t", "q0", "q1", "q2", "q3", "omega1", "omega2", "omega3", "kinetic", "potential", "total", "work",
           "energy_residual"]


def read_npy(content):
    """Names and rows of a file of NumPy with fields of 8 bytes."""
    assert content[:8] == b"\x93NUMPY\x01\x00"
    length, = struct.unpack("<H", content[8:10])
    header = eval(content[10:10 + length], {"__builtins__": {}})  # pylint: disable=eval-used
    assert (10 + length) % 64 == 0 and header["fortran_order"] is False
    codes = "".join({"<i8": "q", "<f8": "d"}[kind] for _, kind in header["descr"])
    rows = list(struct.iter_unpack("<" + codes, content[10 + length:]))
    assert (len(rows),) == header["shape"]
    return [name for name, _ in header["descr"]], rows


class SweepTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("tumble.nml", TUMBLE)

    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def sweep(self, *arguments, output="tumble.npy"):
        """The bytes of the rows."""
        self.succeed("sweep", "tumble.nml", "--quiet", "--output", output, *arguments)
        return self.bytes_of(output)

    def has_threads(self):
        return "threads" in self.succeed("--version").stdout


class Rows(SweepTest):
    def test_rows_are_numpy(self):
        names, rows = read_npy(self.sweep())
        self.assertEqual(names, ["member", "status", *VARIED, *COLUMNS, "largest_energy_residual", "largest_momentum_error",
                                 "flip_count", "flip_first"])
        self.assertEqual([row[0] for row in rows], list(range(1, 201)))
        for row in map(lambda row: dict(zip(names, row)), rows):
            self.assertEqual(row["status"], 0)
            self.assertAlmostEqual(row["t"], 0.5, delta=1e-15)
            self.assertLess(row["largest_energy_residual"], 1e-14)
            self.assertLess(row["largest_momentum_error"], 1e-14)
            self.assertEqual(row["flip_count"] > 0, row["flip_first"] == row["flip_first"])
        self.assertGreater(sum(row[names.index("flip_count")] for row in rows), 20)
        self.assertEqual(self.names(), ["box.nml", "top.nml", "tumble.nml", "tumble.npy", "tumble.npy.txt"])

    def test_each_event_has_a_name(self):
        more = ("&event when = 'omega3', crosses = 9.0 /\n" * 2 + "&event name = 'omega3_2', when = 'omega2', crosses = 0.0 /\n" +
                "&event when = 'omega3', extremum = 'both' /\n")
        self.write("tumble.nml", TUMBLE + more)
        names, _ = read_npy(self.sweep())
        self.assertEqual(names[-10:], [f"{name}_{what}" for name in ("flip", "omega3", "omega3_3", "omega3_2", "omega3_4")
                                       for what in ("count", "first")])
        for first, second in (("a", "a"), ("turn over", "turn_over"), ("q0, 0", "q0;_0")):
            self.write("tumble.nml", TUMBLE + "".join(f"&event when = 'q1', name = '{name}', crosses = 0.1 /\n"
                                                      for name in (first, second)))
            for command in ("sweep", "check"):
                self.fail_with(2, command, "tumble.nml", says=["tumble.nml:12: two events have the columns", "a name for each"])

    def test_the_listing_names_fields_and_statuses(self):
        names, _ = read_npy(self.sweep())
        text = self.read("tumble.npy.txt")
        for name in names:
            self.assertRegex(text, rf"(?m)^ *\d+  [if]8  {re.escape(name)}$")
        self.assertIn("rejected: the inertia is not that of a rigid body", text)
        self.assertIn("arithmetic as written", text)

    def test_csv_has_the_same_numbers(self):
        names, rows = read_npy(self.sweep("--csv", "rows.csv"))
        lines = self.read("rows.csv").splitlines()
        self.assertEqual(lines[0].split(","), names)
        for line, row in zip(lines[1:], rows):
            for text, number in zip(line.split(","), row):
                self.assertTrue(float(text) == number if text else number != number)
        self.assertEqual(len(lines), len(rows) + 1)
        done = self.succeed("sweep", "tumble.nml", "--resume", "--csv", "-")
        self.assertEqual(done.stdout.splitlines(), lines)
        self.assertIn("tumble.npy is complete", done.stderr)

    def test_a_byte_order_of_other_programs_does_not_matter(self):
        self.succeed("sweep", "tumble.nml", "--quiet", "--output", "a.npy", "--csv", "a.csv", "--set", "ensemble.members=5")
        self.succeed("sweep", "tumble.nml", "--quiet", "--output", "b.npy", "--csv", "b.csv", "--set", "ensemble.members=5",
                     env={**os.environ, "GFORTRAN_CONVERT_UNIT": "big_endian", "FORT_CONVERT": "BIG_ENDIAN"})
        for ending in ("npy", "csv"):
            self.assertEqual(self.bytes_of("a." + ending), self.bytes_of("b." + ending))

    def test_the_same_bytes_for_every_chunk(self):
        whole = self.sweep(*FEW)
        for chunk in (1, 7, 60, 1000):
            self.assertEqual(self.sweep(*FEW, "--set", f"ensemble.chunk={chunk}"), whole)

    def test_the_same_bytes_for_every_number_of_threads(self):
        whole = self.sweep(*FEW)
        if not self.has_threads():
            self.fail_with(2, "sweep", "tumble.nml", "--threads", "2", says=["built without threads"])
            self.skipTest("a build without threads")
        for threads in (2, 3, 8):
            self.assertEqual(self.sweep(*FEW, "--threads", str(threads)), whole)
            self.assertEqual(self.sweep(*FEW, "--threads", str(threads), "--set", "ensemble.chunk=3"), whole)

    def test_another_seed_is_another_ensemble(self):
        self.assertNotEqual(self.sweep("--set", "ensemble.seed=2"), self.sweep())

    def test_a_longer_ensemble_begins_like_a_shorter_one(self):
        _, rows = read_npy(self.sweep())
        _, more = read_npy(self.sweep("--set", "ensemble.members=210"))
        self.assertEqual(repr(more[:200]), repr(rows))

    def test_a_member_is_the_run_of_the_scene_with_its_numbers(self):
        names, rows = read_npy(self.sweep())
        row = dict(zip(names, rows[41]))
        settings = []
        for key, count in (("initial.angular_velocity", 3), ("body.inertia", 3), ("initial.quaternion", 4)):
            values = ",".join(repr(row[f"{key}.{i + 1}"]) for i in range(count))
            settings += ["--set", f"{key}={values}"]
        self.succeed("run", "tumble.nml", "--quiet", "--output", "run.csv", *settings)
        header, history = self.history("run.csv")
        self.assertEqual([row[name] for name in header], history[-1])

    def test_members_that_the_scene_refuses_are_rows(self):
        self.write("tumble.nml", TUMBLE.replace("low = 4.9, 19.6", "low = 1.0, 19.6"))
        names, rows = read_npy(self.sweep())
        refused = [row for row in rows if row[1]]
        self.assertTrue(20 < len(refused) < 180)
        for row in refused:
            self.assertEqual(row[1], 6)
            self.assertLess(row[names.index("body.inertia.1")], 4.0)
            self.assertNotEqual(row[names.index("t")], row[names.index("t")])
        done = self.succeed("sweep", "tumble.nml")
        self.assertRegex(done.stderr, rf"status 6 +{len(refused)}: rejected")
        self.assertRegex(done.stderr, rf"the first +member {refused[0][0]}: .*")
        self.fail_with(3, "sweep", "tumble.nml", "--member", str(refused[0][0]), says=[f"member {refused[0][0]}: "])

    def test_a_pole_beyond_a_right_angle_is_a_row(self):
        self.write("pole.nml", "&body inertia = 1, 2, 2.5 /\n&initial tumbling = 'sam', precession_period = 100, period_axis = 'short',"
                   " rotation_period = 300, pole = 20, 80, degrees = .true. /\n&integrator method = 'exact', time_step = 1, end_time = 1 /\n"
                   "&ensemble members = 2 /\n&vary key = 'initial.pole.2', distribution = 'grid', low = 85, high = 95, points = 2 /\n")
        page = self.succeed("sweep", "pole.nml", "--csv", "pole.csv").stderr
        self.assertIn("member 2: the latitude of the pole is 95 (expected -90 to 90 degrees)", page)
        self.assertIn("\n2,7,95,", self.read("pole.csv"))

    def test_members_beyond_the_step_limit_are_rows(self):
        self.write("tumble.nml", TUMBLE + "&vary key = 'integrator.end_time', distribution = 'uniform', low = 0.3, high = 0.7 /\n")
        names, rows = read_npy(self.sweep("--max-steps", "50"))
        ends = names.index("integrator.end_time")
        self.assertEqual([row[1] for row in rows], [9 if row[ends] > 0.5 else 0 for row in rows])
        self.assertEqual({row[1] for row in rows}, {0, 9})
        done = self.nutate("sweep", "tumble.nml", "--max-steps", "29", "--output", "none.npy")
        self.assertEqual(done.returncode, 3)
        self.assertRegex(done.stderr, r"status 9 +200: ")

    def test_more_members_than_rows_are_allowed_are_rejected(self):
        self.fail_with(2, "sweep", "tumble.nml", "--max-rows", "199", says=["200 members", "--max-rows", "199"])
        self.assertNotIn("tumble.npy", self.names())
        self.sweep("--max-rows", "200")
        self.sweep("--max-rows", "3", "--members", "7:9", output="part.npy")

    def test_an_ensemble_of_which_nothing_comes_fails(self):
        done = self.nutate("sweep", "tumble.nml", "--set", "ensemble.members=3", "--set", "body.check_triangle=.true.",
                           "--set", "integrator.time_step=-0.01")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.write("tumble.nml", TUMBLE.replace("low = 4.9, 19.6, 16.7, high = 5.1", "low = 0.1, 19.6, 16.7, high = 0.2"))
        done = self.nutate("sweep", "tumble.nml", "--quiet")
        self.assertEqual(done.returncode, 3, done.stderr)


class Looks(SweepTest):
    """Where the scene asks for no rows, some hundred steps are looked at: seen in the largest errors alone."""

    SCENE = TUMBLE.replace(", every = 10", "").replace("members = 200", "members = 20").replace("&event", "! &event").replace(
        "&integrator", "&rotor momentum = 0.0, 1.0, 2.0 /\n&integrator")

    def scene(self, steps, **changes):
        text = self.SCENE.replace("time_step = 0.01, end_time = 0.5", f"time_step = 0.001, end_time = {steps/1000}")
        for old, new in changes.items():
            text = text.replace(old, new)
        self.write("tumble.nml", text)

    def test_a_member_alone_has_the_row_of_the_ensemble(self):
        for steps in (99, 1000, 1005):
            for method in ("method = 'taylor', ", ""):
                self.scene(steps, **{"formulation = 'reduced', ": method})
                self.sweep("--csv", "rows.csv")
                lines = self.read("rows.csv").splitlines()
                self.assertEqual(self.sweep("--set", "ensemble.chunk=1", output="alone.npy"), self.bytes_of("tumble.npy"))
                done = self.succeed("sweep", "tumble.nml", "--member", "17")
                self.assertEqual(done.stdout.splitlines(), [lines[0], lines[17]])
                self.assertEqual(len(self.history("tumble.member17.csv")[1]), steps + 1)

    def test_the_end_is_that_of_all_rows(self):
        self.scene(1005)
        names, few = read_npy(self.sweep())
        _, many = read_npy(self.sweep("--set", "output.every=1"))
        last = names.index("largest_energy_residual")
        self.assertEqual([row[:last] for row in few], [row[:last] for row in many])
        for row, whole in zip(few, many):
            for field in (last, last + 1):
                self.assertTrue(0 < row[field] <= whole[field] * (1 + 1e-12) < 1e-13, (row[field], whole[field]))
        _, tenth = read_npy(self.sweep("--set", "output.every=10"))
        self.assertEqual(few, tenth)


class Members(SweepTest):
    def test_one_member_again_is_its_row(self):
        self.sweep("--csv", "rows.csv")
        lines = self.read("rows.csv").splitlines()
        for member in (1, 42, 200):
            done = self.succeed("sweep", "tumble.nml", "--member", str(member))
            self.assertEqual(done.stdout.splitlines(), [lines[0], lines[member]])
            header, rows = self.history(f"tumble.member{member}.csv")
            self.assertEqual(header, COLUMNS)
            self.assertEqual(len(rows), 6)
            self.assertEqual([repr(x) for x in rows[-1]],
                             [repr(float(x)) for x in lines[member].split(",")[2 + len(VARIED):-4]])

    def test_histories_are_those_of_the_members(self):
        self.succeed("sweep", "tumble.nml", "--quiet", "--set", "ensemble.histories=2,17")
        for member in (2, 17):
            history = self.read(f"tumble.member{member}.csv")
            self.succeed("sweep", "tumble.nml", "--member", str(member), "--output", "again.csv")
            self.assertEqual(self.read("again.csv"), history)
            self.assertEqual(self.read("again.events.csv"), self.read(f"tumble.member{member}.events.csv"))

    def test_parts_are_put_together(self):
        whole = self.sweep(output="whole.npy")
        for first, last in ((1, 60), (61, 61), (62, 200)):
            self.succeed("sweep", "tumble.nml", "--quiet", "--members", f"{first}:{last}")
        # A name whose numbers are too long for members belongs to no part.
        self.write("tumble.99999999999999999999-1.npy", "")
        self.succeed("sweep", "tumble.nml", "--quiet", "--merge")
        self.assertEqual(self.bytes_of("tumble.npy"), whole)
        self.assertEqual(self.read("tumble.npy.txt"), self.read("whole.npy.txt"))

    def test_parts_that_do_not_fit_are_refused(self):
        self.succeed("sweep", "tumble.nml", "--quiet", "--members", "1:60")
        self.fail_with(2, "sweep", "tumble.nml", "--merge", says=["members 61 to 200", "tumble.61-200.npy"])
        self.succeed("sweep", "tumble.nml", "--quiet", "--members", "50:200")
        self.fail_with(2, "sweep", "tumble.nml", "--merge", says=["member 50 is in two files"])
        os.remove(self.path("tumble.50-200.npy"))
        self.succeed("sweep", "tumble.nml", "--quiet", "--members", "61:200", "--set", "integrator.end_time=0.4")
        self.fail_with(2, "sweep", "tumble.nml", "--merge", says=["tumble.61-200.npy belongs to another sweep"])
        self.assertNotIn("tumble.npy", self.names())

    def test_what_is_asked_for_must_be_there(self):
        self.fail_with(2, "sweep", "tumble.nml", "--members", "1:201", says=["no member 201", "1 to 200"])
        self.fail_with(2, "sweep", "tumble.nml", "--member", "0", says=["not the number of a member"])
        self.fail_with(2, "sweep", "tumble.nml", "--members", "5", says=["expected A:B"])
        self.fail_with(2, "sweep", "tumble.nml", "--member", "1", "--resume", says=["--member cannot be combined"])
        self.fail_with(2, "sweep", "box.nml", says=["no group &ensemble"])
        self.fail_with(2, "sweep", "tumble.nml", "--output", "tumble.nml", says=["the scene itself"])
        self.fail_with(2, "sweep", "tumble.nml", "--output", "rows.csv", says=["rows.csv is the name of a CSV file", "--csv FILE for CSV"])
        self.fail_with(2, "sweep", "tumble.nml", "--set", "ensemble.file=rows.csv", says=["rows.csv is the name of a CSV file"])
        self.fail_with(2, "run", "tumble.nml", "--threads", "2", says=["no option --threads"])


class Sums(SweepTest):
    MEANS = ("--set", "ensemble.rows=none")

    def test_mean_and_counts_are_those_of_the_rows(self):
        names, rows = read_npy(self.sweep())
        self.sweep(*self.MEANS, output="mean.csv")
        lines = [line.split(",") for line in self.read("mean.csv").splitlines()]
        self.assertEqual(lines[0], ["field", "members", "mean", "deviation", "least", "greatest"])
        self.assertEqual(lines[-1][:2], ["status_0", "200"])
        for line in lines[1:-1]:
            values = [row[names.index(line[0])] for row in rows]
            values = [value for value in values if value == value]
            mean = sum(values) / len(values)
            spread = (sum((value - mean) ** 2 for value in values) / (len(values) - 1)) ** 0.5
            scale = max(abs(value) for value in values)
            self.assertEqual(int(line[1]), len(values))
            self.assertAlmostEqual(float(line[2]), mean, delta=1e-14 * scale)
            self.assertAlmostEqual(float(line[3]), spread, delta=1e-13 * scale)
            self.assertEqual([float(line[4]), float(line[5])], [min(values), max(values)])

    def test_the_order_of_the_sums_is_that_of_the_members(self):
        whole = self.sweep(*FEW, *self.MEANS, output="mean.csv")
        for chunk in (1, 13, 60):
            settings = (*FEW, *self.MEANS, "--set", f"ensemble.chunk={chunk}")
            self.assertEqual(self.sweep(*settings, output="mean.csv"), whole)
            if self.has_threads():
                self.assertEqual(self.sweep(*settings, "--threads", "3", output="mean.csv"), whole)

    def test_rows_that_are_not_kept_cannot_be_merged(self):
        self.fail_with(2, "sweep", "tumble.nml", *self.MEANS, "--merge", says=["keeps no rows"])


class Interrupted(SweepTest):
    """Sweeps of many chunks, interrupted after some of them."""

    LONG = ("--set", "integrator.end_time=4", "--set", "ensemble.chunk=3")
    whole = {}

    def setUp(self):
        super().setUp()
        self.threads = ("--threads", "2") if self.has_threads() else ()

    def interrupt(self, number, chunks, output, *arguments):
        """Sends a signal to a sweep that has written so many more chunks, or has ended: its status and standard error."""
        before = chunks_done(self.path(output))
        run = subprocess.Popen([self.program, "sweep", "tumble.nml", "--quiet", "--output", output, *arguments, *self.threads],
                               cwd=self.folder, stderr=subprocess.PIPE, text=True)
        wait_until(lambda: chunks_done(self.path(output)) >= before + chunks or run.poll() is not None)
        run.send_signal(number)
        _, said = run.communicate(timeout=PATIENCE)
        return run.returncode, said

    def resumes(self, number, rounds, output, *arguments):
        """Interrupted again and again, the bytes in the end are those of a sweep that was not."""
        if output not in self.whole:
            self.whole[output] = self.sweep(*arguments, *self.LONG, output="whole" + output)
        dice = random.Random(number)
        ended = 0
        for _ in range(4*rounds):
            code, said = self.interrupt(number, dice.randint(1, 6), output, "--resume", *arguments, *self.LONG)
            self.assertIn(code, (0, -number), said)
            ended += code == -number
            if ended == (2 if ONE_IN > 3 else rounds):
                break
            if code == 0:
                # It was over before the signal came: anew.
                os.remove(self.path(output))
        self.succeed("sweep", "tumble.nml", "--quiet", "--output", output, "--resume", *arguments, *self.LONG)
        self.assertEqual(self.bytes_of(output), self.whole[output])
        self.assertGreater(ended, 0)
        self.assertNotIn(output + ".partial", self.names())

    def test_killed_and_resumed(self):
        self.resumes(signal.SIGKILL, 5, "rows.npy")

    def test_killed_and_resumed_sums(self):
        self.resumes(signal.SIGKILL, 4, "mean.csv", *Sums.MEANS)

    def test_stopped_and_resumed(self):
        self.resumes(signal.SIGINT, 4, "rows.npy")

    def test_a_signal_is_answered_in_one_line(self):
        code, said = self.interrupt(signal.SIGTERM, 1, "tumble.npy", "--set", "integrator.end_time=100")
        self.assertEqual(code, -signal.SIGTERM, said)
        self.assertRegex(said, r"^nutate: tumble\.nml: stopped by SIGTERM; \d+ of 200 members are in tumble\.npy\.partial "
                               r"\(nutate sweep --resume continues\)\n$")
        self.fail_with(2, "sweep", "tumble.nml", "--resume", says=["tumble.npy.partial belongs to another sweep"])

    def test_histories_that_are_not_complete_are_run_again(self):
        options = ("--quiet", "--set", "ensemble.members=3", "--set", "integrator.end_time=500", "--set", "output.every=10",
                   "--set", "ensemble.histories=2,3")
        self.succeed("sweep", "tumble.nml", "--output", "whole.npy", *options)
        for rows, stem, keeps in (("rows.npy", "rows", "final"), ("mean.csv", "mean.csv", "none")):
            for number in (signal.SIGKILL, signal.SIGTERM):
                sweep = ("sweep", "tumble.nml", "--output", rows, "--set", "ensemble.rows=" + keeps, *options)
                partial = self.path(stem + ".member2.csv.partial")
                run = subprocess.Popen([self.program, *sweep], cwd=self.folder, stderr=subprocess.PIPE, text=True)
                wait_until(lambda: os.path.exists(partial) or run.poll() is not None)
                run.send_signal(number)
                run.communicate(timeout=PATIENCE)
                self.succeed(*sweep, "--resume")
                for member in (2, 3):
                    self.assertEqual(self.read(f"{stem}.member{member}.csv"), self.read(f"whole.member{member}.csv"))
                    os.remove(self.path(f"{stem}.member{member}.csv"))
                os.remove(self.path(rows))

    def test_histories_that_cannot_be_written_are_run_again(self):
        sweep = ("sweep", "tumble.nml", "--quiet", "--set", "ensemble.members=3", "--set", "ensemble.histories=2")
        for name, keeps in (("rows", "final"), ("mean.csv", "none")):
            output = ("--output", name.replace("rows", "rows.npy"), "--set", "ensemble.rows=" + keeps)
            history = self.path(name + ".member2.csv")
            os.mkdir(history)
            self.fail_with(4, *sweep, *output, says=[f"member 2: cannot write {name}.member2.csv: ", "(nutate sweep --resume continues)"])
            os.rmdir(history)
            self.succeed(*sweep, *output, "--resume")
            self.assertTrue(os.path.isfile(history))

    def test_what_is_not_marked_is_run_again(self):
        whole = self.sweep(output="whole.npy")
        self.interrupt(signal.SIGKILL, 1, "tumble.npy", "--set", "integrator.end_time=40", "--set", "ensemble.chunk=20")
        self.assertIn("tumble.npy.partial", self.names())
        self.assertEqual(self.sweep(), whole)


class Finished(SweepTest):
    """What --resume does where the file is whole."""

    MEANS = Sums.MEANS
    OTHERS = (("--set", "ensemble.seed=2"), ("--set", "integrator.time_step=0.005"), ("--set", "initial.angular_velocity=0,0,1"),
              ("--members", "1:100"))

    def test_the_finished_file_of_another_sweep_is_refused(self):
        for name, more in (("rows.npy", ()), ("mean.csv", self.MEANS)):
            rows = self.sweep(*more, output=name)
            for other in self.OTHERS:
                if more and other[0] == "--members":
                    continue
                said = self.fail_with(2, "sweep", "tumble.nml", "--output", name, "--resume", *more, *other,
                                      says=[name, "another sweep", "--resume"])
                self.assertEqual(said.stderr.count("\n"), 1)
                self.assertEqual(self.bytes_of(name), rows)
            before = os.stat(self.path(name)).st_mtime_ns
            self.assertIn("is complete", self.succeed("sweep", "tumble.nml", "--output", name, "--resume", *more).stderr)
            self.assertEqual(os.stat(self.path(name)).st_mtime_ns, before)
            os.remove(self.path(name + ".txt"))
            self.fail_with(2, "sweep", "tumble.nml", "--output", name, "--resume", *more, says=[name + ".txt is missing"])
            self.assertEqual(self.bytes_of(name), rows)

    def test_histories_can_be_added(self):
        sweep = ("sweep", "tumble.nml", "--quiet", "--set", "ensemble.members=3")
        for name, stem, more in (("rows.npy", "rows", ()), ("mean.csv", "mean.csv", self.MEANS)):
            self.succeed(*sweep, "--output", name, *more)
            before = os.stat(self.path(name)).st_mtime_ns
            self.succeed(*sweep, "--output", name, "--resume", *more, "--set", "ensemble.histories=2,3")
            self.assertEqual(os.stat(self.path(name)).st_mtime_ns, before)
            for member in ("2", "3"):
                self.succeed(*sweep, "--member", member, "--output", "one.csv")
                self.assertEqual(self.read(f"{stem}.member{member}.csv"), self.read("one.csv"))

    def test_without_resume_another_sweep_takes_its_place(self):
        rows = self.sweep()
        self.assertNotEqual(self.sweep("--set", "ensemble.seed=2"), rows)

    def test_a_file_of_means_without_members_fails_again(self):
        self.write("tumble.nml", TUMBLE.replace("low = 4.9, 19.6, 16.7, high = 5.1", "low = 0.1, 19.6, 16.7, high = 0.2"))
        for _ in range(2):
            done = self.nutate("sweep", "tumble.nml", "--output", "mean.csv", "--resume", *self.MEANS)
            self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("mean.csv is complete", done.stderr)


class Tables(SweepTest):
    SCENE = TUMBLE.replace("members = 200", "table = 'cases.csv'").split("&vary")[0]

    def setUp(self):
        super().setUp()
        self.write("tumble.nml", self.SCENE)

    def test_a_table_has_a_line_for_each_member(self):
        self.write("cases.csv", "body.inertia.1,initial.angular_velocity.3\n5.0,1.5\n5.1,2.5\n5.2,-3e0\n")
        names, rows = read_npy(self.sweep())
        self.assertEqual(names[2:4], ["body.inertia.1", "initial.angular_velocity.3"])
        self.assertEqual([row[2:4] for row in rows], [(5.0, 1.5), (5.1, 2.5), (5.2, -3.0)])

    def test_a_table_from_a_spreadsheet(self):
        self.write("cases.csv", '\ufeff"body.inertia.1", "initial.angular_velocity.3"\r\n"5.0",1.5\r\n5.1,"2.5"\r\n')
        self.assertEqual([row[2:4] for row in read_npy(self.sweep())[1]], [(5.0, 1.5), (5.1, 2.5)])

    def test_faults_of_a_table_are_named_with_their_line(self):
        for text, says in (("body.inertia.4\n1\n", "cases.csv:1: 'body.inertia.4' is beyond the last number"),
                           ("body.inertia\n1\n", "cases.csv:1: column 'body.inertia' stands for several numbers"),
                           ("body.inertia.1\n5\nfive\n", "cases.csv:3: 'five' is not a number"),
                           ("body.inertia.1\n", "cases.csv:1: the table has no line"),
                           ("body.mass,body.mass\n1,2\n", "cases.csv:1: body.mass is varied twice"),
                           ("spin\n1\n", "cases.csv:1: 'spin' is not the name of a number")):
            self.write("cases.csv", text)
            self.fail_with(2, "sweep", "tumble.nml", says=[says])
        self.write("cases.csv", "body.inertia.1\n5\n6\n")
        self.fail_with(2, "sweep", "tumble.nml", "--set", "ensemble.members=3", says=["more members than lines"])


class Scenes(SweepTest):
    def rows_of(self, scene, *settings):
        """Members of a scene that comes along, as dictionaries."""
        overrides = [word for setting in settings for word in ("--set", setting)]
        self.succeed("sweep", os.path.join(SCENES, scene), "--quiet", "--output", "rows.npy", *overrides)
        names, rows = read_npy(self.bytes_of("rows.npy"))
        rows = [dict(zip(names, row)) for row in rows]
        self.assertEqual({row["status"] for row in rows}, {0})
        for error in ("largest_energy_residual", "largest_momentum_error"):
            self.assertLess(max(row[error] for row in rows), 1e-14)
        return rows

    def test_a_satellite_forgets_where_it_pointed(self):
        for seconds, median, tolerance in ((10, 39, 5), (600, 88, 15)):
            rows = self.rows_of("separation.nml", "ensemble.members=300", f"integrator.end_time={seconds}")
            angles = sorted(math.degrees(math.acos(1 - 2*(row["q1"]**2 + row["q2"]**2))) for row in rows)
            self.assertAlmostEqual(angles[150], median, delta=tolerance)

    def test_a_book_comes_down_on_its_back_after_two_turns(self):
        rows = self.rows_of("thrown_book.nml", "ensemble.members=300")
        for turns, least, most in ((1, 0, 5), (2, 70, 95)):
            throws = [row for row in rows if row["integrator.end_time"] == turns/4]
            self.assertEqual(len(throws), 50)
            on_back = 2*sum(row["theta"] > math.pi/2 for row in throws)
            self.assertTrue(least <= on_back <= most, (turns, on_back))

    def test_apophis_spins_faster_or_slower_after_its_passage(self):
        rows = self.rows_of("apophis_ensemble.nml", "ensemble.members=400")
        self.succeed("run", os.path.join(SCENES, "apophis_ensemble.nml"), "--quiet", "--output", "one.csv")
        header, history = self.history("one.csv")

        def rate(row):
            return 2*row["kinetic"]/math.hypot(row["l_x"], row["l_y"], row["l_z"])

        rates = [rate(row)/rate(dict(zip(header, history[0]))) for row in rows]
        self.assertTrue(0.585 < min(rates) < 0.62 and 1.54 < max(rates) < 1.59, (min(rates), max(rates)))
        # 94.5 % of 10 000 members, within four deviations of 400.
        self.assertAlmostEqual(sum(row["short_axis_mode"] for row in rows)/400, 0.945, delta=0.046)
        # Only bodies that lose rotation leave the mode.
        self.assertLess(max(rate for rate, row in zip(rates, rows) if row["short_axis_mode"] < 0.5), 0.9)


if __name__ == "__main__":
    unittest.main()

"""nutate run: what the history holds and the words for it."""
import math
import os
import re
import subprocess
import unittest

from support import COLUMNS, PATIENCE, CommandLineTest, all_columns, parse


class History(CommandLineTest):
    def test_default_columns_are_in_the_file_named_by_the_scene(self):
        self.succeed("run", "box.nml")
        header, rows = self.history("box.csv")
        expected = ["t"]
        for name in ("quaternion", "angular_velocity", "energy", "constraints"):
            expected += COLUMNS[name]
        self.assertEqual(header, expected)
        self.assertEqual(len(rows), 51)
        self.assertEqual(self.names(), ["box.csv", "box.nml", "top.nml"])

    def test_first_row_is_the_initial_state(self):
        self.succeed("run", "box.nml")
        _, rows = self.history("box.csv")
        energy = 0.5 * (5 * 0.1**2 + 17 * 10.0**2)
        self.assertEqual(rows[0][:9], [0, 1, 0, 0, 0, 0.1, 0, 10, energy])

    def test_last_row_is_at_end_time_exactly(self):
        for end in ("0.5", "0.537", "0.1000000001"):
            self.succeed("box.nml", "--set", f"integrator.end_time={end}")
            _, rows = self.history("box.csv")
            self.assertEqual(rows[-1][0], float(end))

    def test_every_set_of_columns_stands_in_its_place(self):
        self.succeed("run", "top.nml", "--set", f"output.columns={all_columns()}")
        header, rows = self.history("top.csv")
        self.assertEqual(header, ["t"] + [name for names in COLUMNS.values() for name in names])
        self.assertTrue(all(len(row) == len(header) and all(map(math.isfinite, row)) for row in rows))

    def test_each_set_of_columns_alone_holds_the_same_values(self):
        self.succeed("run", "top.nml", "--set", f"output.columns={all_columns()}")
        header, rows = self.history("top.csv")
        for name, columns in COLUMNS.items():
            self.succeed("run", "top.nml", "--set", f"output.columns='{name}'", "--output", "one.csv")
            one_header, one_rows = self.history("one.csv")
            self.assertEqual(one_header, ["t"] + columns)
            first = header.index(columns[0])
            self.assertEqual([row[1:] for row in one_rows], [row[first:first + len(columns)] for row in rows])

    def test_columns_agree_with_each_other(self):
        self.succeed("run", "top.nml", "--set", f"output.columns={all_columns()}")
        header, rows = self.history("top.csv")
        for row in rows[::20]:
            at = dict(zip(header, row))
            q = [at["q0"], at["q1"], at["q2"], at["q3"]]
            body = [at["L1"], at["L2"], at["L3"]]
            space = rotate(q, body)
            for value, name in zip(space, ("l_x", "l_y", "l_z")):
                self.assertAlmostEqual(value, at[name], delta=1e-12 * 60)
            rate = [at["omega1"], at["omega2"], at["omega3"]]
            for value, name in zip(rotate(q, rate), ("omega_x", "omega_y", "omega_z")):
                self.assertAlmostEqual(value, at[name], delta=1e-12 * 60)
            self.assertAlmostEqual(at["omega1"], at["L1"] / 5, delta=1e-13 * 60)
            kinetic = 0.5 * (body[0]**2 / 5 + body[1]**2 / 5 + body[2]**2)
            self.assertAlmostEqual(at["kinetic"], kinetic, delta=1e-12 * 1300)
            self.assertAlmostEqual(at["potential"], 20 * math.cos(at["theta"]), delta=1e-12 * 20)
            self.assertAlmostEqual(at["total"], at["kinetic"] + at["potential"], delta=1e-12 * 1300)
            self.assertAlmostEqual(at["norm_error"], sum(x * x for x in q) - 1, delta=1e-15)

    def test_invariants_hold(self):
        self.succeed("run", "top.nml", "--set", "output.columns='energy','constraints','angular_momentum_space'")
        header, rows = self.history("top.csv")
        at = {name: [row[i] for row in rows] for i, name in enumerate(header)}
        self.assertLess(max(map(abs, at["energy_residual"])), 1e-13 * 1270)
        self.assertLess(max(abs(l - at["l_z"][0]) for l in at["l_z"]), 1e-13 * 50)
        self.assertLess(max(map(abs, at["norm_error"])), 1e-13)
        self.assertGreater(max(abs(l - at["l_x"][0]) for l in at["l_x"]), 1e-2)

    def test_angles_keep_their_turns_between_rare_rows(self):
        arguments = ("run", "top.nml", "--set", "output.columns='euler'")
        self.succeed(*arguments)
        _, rows = self.history("top.csv")
        self.succeed(*arguments, "--set", "output.every=50", "--output", "rare.csv")
        _, rare = self.history("rare.csv")
        self.assertEqual(rare, rows[::50])
        self.assertGreater(rows[-1][3], 40.0)

    def test_angles_keep_the_turns_of_subdivided_steps(self):
        self.write("spin.nml", "&body inertia = 1.0, 1.0, 1.5 /\n&initial angular_velocity = 0.0, 0.0, 10.0 /\n"
                               "&integrator time_step = 1.0, end_time = 3.0 /\n&output columns = 'euler' /\n")
        self.succeed("run", "spin.nml")
        # 10 rad a step in four parts, each of which the scheme turns by 4 atan(2.5/4).
        for number, row in enumerate(self.history("spin.csv")[1]):
            self.assertAlmostEqual(row[1] + row[3], number*16*math.atan(0.625), delta=1e-13)

    def test_angles_that_start_at_a_pole_go_on_from_there(self):
        tilted = ("--set", "initial.angular_velocity=0.03, 0.1, 5", "--set", "output.columns=euler")
        for attitude in ("1, 0, 0, 0", "0.6, 0, 0, -0.8", "0, 0.6, 0.8, 0"):
            for sign in ("", "-"):
                self.succeed("run", "box.nml", *tilted, "--set", "initial.quaternion=" + attitude,
                             "--set", f"integrator.time_step={sign}0.01", "--set", f"integrator.end_time={sign}0.1")
                rows = self.history("box.csv")[1]
                self.assertIn(rows[0][2], (0.0, math.pi))
                for before, after in zip(rows, rows[1:]):
                    self.assertLess(max(abs(a - b) for a, b in zip(before, after)), 0.1)

    def test_steps_end_at_rest(self):
        # J3 θ'' = -m b sin θ from rest at 1.1 rad: at rest again after each half of the period 4 K(sin 0.55) √(4/3) s.
        # The torque that starts later makes the momentum of taylor a compensated sum.
        period = 7.845222360554189
        self.write("needle.nml", "&body inertia = 2, 3, 4 /\n&dipole moment = 1.5, 0, 0, field = 2, 0, 0 /\n"
                   "&initial axis = 0, 0, 1, angle = 1.1, angular_velocity = 0, 0, 0 /\n&torque body = 0.1, 0, 0, start = 90 /\n"
                   f"&integrator time_step = {period/100!r}, end_time = {2*period!r} /\n")
        for method in ("taylor", "rk8", "dop853", "nielsen_krenk"):
            order = ("--set", "integrator.order=8") if method == "nielsen_krenk" else ()
            self.succeed("run", "needle.nml", "--set", "integrator.method=" + method, *order)
            for row in self.history("needle.csv")[1][::50]:
                self.assertAlmostEqual(abs(row[4]), math.sin(0.55), delta=1e-9, msg=method)

    def test_steps_without_a_proof_are_said(self):
        # The ends of the spring meet at the start, where its force has no bound on its derivatives.
        self.write("meeting.nml", "&body inertia = 1.0, 2.0, 2.5 /\n&initial angular_velocity = 0.3, 1.0, 0.2 /\n"
                                  "&spring body_point = 0.3, 0.0, 0.1, anchor = 0.3, 0.0, 0.1, stiffness = 4.0, "
                                  "rest_length = 0.2 /\n&integrator time_step = 0.01, end_time = 0.1 /\n")
        done = self.succeed("run", "meeting.nml")
        self.assertRegex(done.stderr, r"not certified +([1-9]|10) of the steps")
        self.assertNotIn("not certified", self.succeed("run", "box.nml").stderr)
        sphere = ("--set", "inner_sphere.inertia=0.1", "--set", "inner_sphere.damping=0.01")
        self.assertRegex(self.succeed("run", "meeting.nml", *sphere).stderr, r"not certified +([1-9]|10) of the steps")
        # No step with a wheel can be certified.
        self.write("wheel.nml", "&body inertia = 1.0, 2.0, 2.5 /\n&initial angular_velocity = 0.3, 1.0, 0.2 /\n"
                                "&wheel axis = 0, 0, 1, inertia = 0.1, speed = 3 /\n&integrator time_step = 0.01, end_time = 0.1 /\n")
        self.assertNotIn("not certified", self.succeed("run", "wheel.nml").stderr)

    def test_numbers_are_short_and_read_back_exactly(self):
        self.succeed("run", "top.nml", "--set", f"output.columns={all_columns()}")
        text = self.read("top.csv")
        self.assertNotIn("\r", text)
        self.assertTrue(text.endswith("\n"))
        self.assertNotIn("nan", text.lower())
        for line in text.splitlines()[1:]:
            for field in line.split(","):
                self.assertLessEqual(len(field), 24)
                self.assertLessEqual(len(digits(field)), 17)
                # No shorter text is the same double, unless 16 digits are left where 17 are needed.
                self.assertGreaterEqual(len(digits(field)), len(digits(repr(float(field)))))
                if len(digits(field)) <= 15:
                    self.assertEqual(digits(field), digits(repr(float(field))))

    def test_rows_can_be_rare(self):
        self.succeed("run", "box.nml", "--set", "output.every=20")
        _, rows = self.history("box.csv")
        self.assertEqual([row[0] for row in rows], [0, 0.2, 0.4, 0.5])

    def test_same_input_gives_the_same_bytes(self):
        self.succeed("run", "top.nml", "--output", "a.csv")
        self.succeed("run", "top.nml", "--output", "b.csv")
        self.assertEqual(self.read("a.csv"), self.read("b.csv"))


class Output(CommandLineTest):
    def test_dash_writes_the_history_and_nothing_else_to_standard_output(self):
        self.succeed("run", "box.nml", "--output", "ref.csv")
        for name in ("-", "/dev/stdout"):
            done = self.succeed("run", "box.nml", "--output", name)
            self.assertEqual(done.stdout, self.read("ref.csv"))
            self.assertIn("energy residual", done.stderr)
        self.assertEqual(self.names(), ["box.nml", "ref.csv", "top.nml"])

    def test_nothing_is_written_to_standard_output_otherwise(self):
        self.assertEqual(self.succeed("run", "box.nml").stdout, "")

    def test_quiet_is_silent(self):
        done = self.succeed("run", "box.nml", "--quiet")
        self.assertEqual((done.stdout, done.stderr), ("", ""))
        self.assertIn("box.csv", self.names())

    def test_scene_alone_is_short_for_run(self):
        self.succeed("box.nml", "--quiet", "--output=short.csv")
        self.succeed("run", "--output", "long.csv", "box.nml")
        self.assertEqual(self.read("short.csv"), self.read("long.csv"))

    def test_option_output_wins_over_the_scene(self):
        self.succeed("run", "box.nml", "--set", "output.file='scene.csv'", "--output", "option.csv")
        self.assertIn("option.csv", self.names())
        self.assertNotIn("scene.csv", self.names())

    def test_overrides_apply_in_order(self):
        self.succeed("run", "box.nml", "--set", "integrator.end_time=0.3", "--set=integrator.end_time=0.2")
        _, rows = self.history("box.csv")
        self.assertEqual(rows[-1][0], 0.2)

    def test_an_earlier_history_is_replaced_only_when_the_run_is_complete(self):
        self.write("box.csv", "t,q0\n0,1\n")
        self.fail_with(3, "run", "box.nml", "--max-steps", "7")
        self.assertEqual(self.read("box.csv"), "t,q0\n0,1\n")
        self.succeed("run", "box.nml")
        self.assertEqual(len(self.history("box.csv")[1]), 51)
        self.assertNotIn("box.csv.partial", self.names())

    def test_a_link_stays_a_link(self):
        os.mkdir(self.path("disk"))
        self.write("disk/real.csv", "")
        os.symlink("disk/real.csv", self.path("box.csv"))
        self.succeed("run", "box.nml")
        self.assertTrue(os.path.islink(self.path("box.csv")))
        self.assertEqual(len(self.history("disk/real.csv")[1]), 51)

    def test_a_pipe_is_written_directly(self):
        os.mkfifo(self.path("pipe"))
        with subprocess.Popen(["cat", self.path("pipe")], stdout=subprocess.PIPE, text=True) as reader:
            self.succeed("run", "box.nml", "--output", "pipe")
            text = reader.communicate(timeout=PATIENCE)[0]
        self.assertEqual(len(parse(text)[1]), 51)
        self.assertNotIn("pipe.partial", self.names())


class Summary(CommandLineTest):
    def test_summary_says_what_was_done_and_kept(self):
        text = self.succeed("run", "top.nml").stderr
        for words in ("200 of 0.005 s, to t = 1 s", "wall time", " ns\n", "per step", "at most", "energy residual",
                      "component along 0, 0, 1", "norm error", "201 rows of 15 columns in top.csv"):
            self.assertIn(words, text)
        self.assertNotIn("subdivided steps", text)
        self.assertNotIn("work of", text)
        self.assertIn("Newton iterations", text)
        self.assertNotIn("Newton", self.succeed("run", "top.nml", "--set", "integrator.method='rk8'").stderr)

    def test_momentum_of_a_free_body_is_kept_whole(self):
        self.assertIn("all components", self.succeed("run", "box.nml").stderr)

    def test_labels_are_aligned(self):
        lines = self.succeed("run", "box.nml").stderr.splitlines()
        self.assertEqual(lines[0], "box.nml: Free box")
        for line in lines[1:]:
            self.assertRegex(line, r"^  \S.{18} \S")


class ProgressBar(CommandLineTest):
    box = None

    def long_run(self, shown, scene, end, *settings):
        """Arguments of a run that is long enough for a bar, and what a terminal shows of it. A bar comes after half a second:
        runs to later and later ends are tried until the terminal shows what is expected."""
        for _ in range(12):
            arguments = ("run", scene, "--set", f"integrator.end_time={end}", *settings)
            seen, status = self.on_terminal(*arguments)
            self.assertEqual(status, 0)
            if re.search(shown, seen):
                return arguments, seen
            end *= 2
        return self.fail(f"no bar: {seen!r}")

    def long_box(self):
        """A long run of the box, found once."""
        if ProgressBar.box is None:
            ProgressBar.box = self.long_run(r"\r\[.*\r\[", "box.nml", 2000, "--set", "output.every=1000000")
        return self.box

    def on_terminal(self, *arguments):
        """Standard error of a run whose standard error is a terminal, and its exit status."""
        try:
            ours, theirs = os.openpty()
        except (AttributeError, OSError) as reason:
            self.skipTest(f"there are no terminals here: {reason}")
        command = [self.program, *arguments]
        with subprocess.Popen(command, cwd=self.folder, stderr=theirs, stdout=subprocess.DEVNULL) as run:
            os.close(theirs)
            seen = b""
            while True:
                try:
                    piece = os.read(ours, 4096)
                except OSError:
                    break
                if not piece:
                    break
                seen += piece
            run.wait(timeout=PATIENCE)
        os.close(ours)
        return seen.decode(), run.returncode

    def test_a_long_run_on_a_terminal_shows_a_bar_and_removes_it(self):
        _, seen = self.long_box()
        self.assertIn(" %, ", seen)
        # Removed by blanks before the summary begins.
        self.assertRegex(seen, r"\] \d+ %[^\r]*\r +\rbox.nml: Free box")

    def test_quiet_shows_none(self):
        self.assertEqual(self.on_terminal(*self.long_box()[0], "--quiet"), ("", 0))

    def test_trial_runs_show_a_bar_each(self):
        long, seen = self.long_run(r"\rtrial run \d+ \[#*\.*\] \d+ % +\r", "top.nml", 20, "--set", "integrator.accuracy=1e-7", "--set",
                                   "integrator.method=nielsen_krenk", "--set", "output.interval=100")
        self.assertRegex(seen, r"\r {76}\rtop.nml: \d+ steps")
        self.assertEqual(self.on_terminal(*long, "--quiet"), ("", 0))

    def test_no_terminal_no_bar(self):
        self.assertNotIn("\r", self.succeed(*self.long_box()[0]).stderr)


def digits(text):
    """The significant digits of a number."""
    mantissa = text.lower().split("e")[0].replace(".", "").replace("-", "").lstrip("0")
    return mantissa.rstrip("0")


def rotate(q, v):
    """R(q) v for a unit quaternion."""
    q0, x, y, z = q
    cross = [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]]
    twice = [y * cross[2] - z * cross[1], z * cross[0] - x * cross[2], x * cross[1] - y * cross[0]]
    return [v[i] + 2 * (q0 * cross[i] + twice[i]) for i in range(3)]


if __name__ == "__main__":
    unittest.main()

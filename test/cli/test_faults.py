"""What goes wrong: one clear line, the right exit status, and never a file that looks complete."""
import fcntl
import os
import resource
import shutil
import signal
import subprocess
import unittest

from support import PATIENCE, CommandLineTest, parse


class SmallStack(CommandLineTest):
    def limited(self, kilobytes, *arguments):
        limit = kilobytes << 10
        return self.nutate(*arguments, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (limit, limit)))

    def test_it_is_named(self):
        done = self.limited(128, "run", "box.nml")
        self.assertEqual((done.returncode, done.stderr),
                         (3, "nutate: the limit of the stack is too small (expected ulimit -s 512, or more)\n"))

    def test_the_smallest_one_is_enough(self):
        self.write("many.nml", self.read("box.nml") + "&ensemble members = 8, seed = 1 /\n"
                   "&vary key = 'body.mass', distribution = 'uniform', low = 1, high = 2 /\n")
        for arguments in (("check", "box.nml"), ("run", "box.nml", "--quiet"), ("sweep", "many.nml", "--quiet")):
            done = self.limited(512, *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)


class BadArguments(CommandLineTest):
    def test_unknown_option_names_the_nearest(self):
        self.fail_with(2, "run", "box.nml", "--quite", says=["--quite", "nearest: --quiet"])

    def test_option_cut_short_names_the_whole(self):
        self.fail_with(2, "run", "box.nml", "--out", "x.csv", says=["--out", "nearest: --output"])
        self.fail_with(2, "run", "box.nml", "--resu", "x.csv", says=["nearest: --resume"])
        self.fail_with(2, "run", "box.nml", "--set", "integrator.time=0.1", says=["nearest: time_step"])

    def test_output_has_a_short_name(self):
        self.succeed("run", "box.nml", "--quiet", "-o", "short.csv")
        self.succeed("run", "box.nml", "--quiet", "--output", "long.csv")
        self.assertEqual(self.read("short.csv"), self.read("long.csv"))
        self.fail_with(2, "run", "box.nml", "-o", "a.csv", "--output", "b.csv", says=["--output is given twice"])
        self.assertIn("-o", self.succeed("run", "--help").stdout)

    def test_unknown_option_without_near_name_points_to_help(self):
        self.fail_with(2, "run", "box.nml", "--frobnicate", says=["--frobnicate", "nutate --help"])

    def test_unknown_command_names_the_nearest(self):
        self.fail_with(2, "chekc", "box.nml", says=["chekc", "nearest: check"])

    def test_option_of_another_command(self):
        self.fail_with(2, "check", "box.nml", "--output", "x.csv", says=["check", "--output"])

    def test_missing_scene(self):
        for arguments in (["run"], ["check"], ["--quiet"]):
            self.fail_with(2, *arguments, says=["scene"])

    def test_two_scenes(self):
        self.fail_with(2, "run", "box.nml", "top.nml", says=["top.nml"])

    def test_missing_value(self):
        self.fail_with(2, "run", "box.nml", "--output", says=["--output", "FILE"])
        self.fail_with(2, "run", "box.nml", "--output", "", says=["--output"])

    def test_value_where_none_belongs(self):
        self.fail_with(2, "run", "box.nml", "--quiet=yes", says=["--quiet"])

    def test_option_given_twice(self):
        self.fail_with(2, "run", "box.nml", "--output", "a", "--output", "b", says=["--output", "twice"])

    def test_bad_number_of_steps(self):
        for number in ("0", "-3", "ten", "1.5", "", "99999999999999999999"):
            self.fail_with(2, "run", "box.nml", f"--max-steps={number}", says=["--max-steps"])
            self.fail_with(2, "run", "box.nml", f"--max-rows={number}", says=["--max-rows"])

    def test_bad_override(self):
        for override in ("nonsense", "integrator.end_tmie=1", "integrater.end_time=1", "integrator.end_time=abc"):
            self.fail_with(2, "run", "box.nml", "--set", override, says=["--set: "])
            self.fail_with(2, "check", "box.nml", "--set", override, says=["--set: "])
        self.assertNotIn("box.csv", self.names())

    def test_control_characters_stay_out_of_the_message(self):
        done = self.fail_with(2, "run", "box.nml", "--a\nb\x1b[31m")
        self.assertNotIn("\x1b", done.stderr)

    def test_words_after_two_dashes_are_no_options(self):
        self.write("--odd.nml", self.read("box.nml"))
        self.succeed("run", "--quiet", "--output", "odd.csv", "--", "--odd.nml")
        self.assertIn("odd.csv", self.names())


class BadScenes(CommandLineTest):
    def test_no_such_file(self):
        self.fail_with(2, "run", "nowhere.nml", says=["nowhere.nml"])
        self.fail_with(2, "nowhere.nml", says=["nowhere.nml"])

    def test_a_name_without_its_ending_names_the_file(self):
        self.fail_with(2, "run", "box", says=["box: cannot be read (there is no such file; did you mean box.nml?)"])
        self.fail_with(2, "sweep", "box", says=["did you mean box.nml?"])
        self.fail_with(2, "box", says=["unknown command 'box' (did you mean box.nml?)"])
        self.fail_with(2, "run", "boxes", says=["boxes: cannot be read (there is no such file)"])
        self.fail_with(2, "run", "/dev/zero", says=["/dev/zero: cannot be read (it has a NUL character)"])
        self.succeed("run", "box.nml", "--quiet")
        if shutil.which("gnuplot"):
            self.fail_with(2, "plot", "box", says=["did you mean box.csv?"])

    def test_folder_as_scene(self):
        os.mkdir(self.path("folder"))
        self.fail_with(2, "run", "folder", says=["folder"])

    @unittest.skipIf(os.geteuid() == 0, "root reads everything")
    def test_unreadable_file(self):
        os.chmod(self.path("box.nml"), 0)
        self.fail_with(2, "run", "box.nml", says=["box.nml", "permission"])

    def test_error_in_the_scene_names_file_and_line_and_writes_nothing(self):
        self.write("bad.nml", self.read("box.nml").replace("time_step", "tiem_step"))
        for command in ("run", "check"):
            done = self.fail_with(2, command, "bad.nml", says=["time_step"])
            self.assertTrue(done.stderr.startswith("bad.nml:4: "), done.stderr)
        self.assertEqual(self.names(), ["bad.nml", "box.nml", "top.nml"])

    def test_scene_is_never_written_over(self):
        before = self.read("box.nml")
        os.link(self.path("box.nml"), self.path("same.nml"))
        for name in ("box.nml", "./box.nml", "same.nml"):
            self.fail_with(2, "run", "box.nml", "--output", name, says=["scene"])
        self.assertEqual(self.read("box.nml"), before)


class BadOutput(CommandLineTest):
    def test_full_disk(self):
        self.fail_with(4, "run", "box.nml", "--output", "/dev/full", says=["/dev/full", "no space left"])

    def test_full_standard_output(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            for arguments in (["run", "box.nml", "--quiet", "--output", "-"], ["check", "box.nml"], ["--help"]):
                done = subprocess.run([self.program, *arguments], cwd=self.folder, stdout=full, stderr=subprocess.PIPE,
                                      text=True, timeout=PATIENCE, check=False)
                self.assertEqual(done.returncode, 4)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_full_standard_output_of_one_member(self):
        self.write("two.nml", self.read("box.nml") + "&ensemble members = 2 /\n"
                   "&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 0.01, 0.5 /\n")
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([self.program, "sweep", "two.nml", "--member", "1", "--quiet"], cwd=self.folder, stdout=full,
                                  stderr=subprocess.PIPE, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1), done.stderr)

    def test_closed_standard_streams(self):
        for arguments, status in (("- >&- 2>&-", 4), ("a.csv <&- >&- 2>&-", 0)):
            shell = f"'{self.program}' run box.nml --output {arguments}"
            done = subprocess.run(["sh", "-c", shell], cwd=self.folder, timeout=PATIENCE, check=False)
            self.assertEqual(done.returncode, status)
        self.succeed("run", "box.nml", "--output", "b.csv")
        self.assertEqual(self.read("a.csv"), self.read("b.csv"))

    def test_disk_that_fills_up_in_mid_run_leaves_whole_rows(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))
        self.fail_with(4, "run", "box.nml", "--set", "integrator.end_time=10", preexec_fn=limit,
                       says=["box.csv", "too large", "box.csv.partial"])
        text = self.read("box.csv.partial")
        self.assertTrue(text.endswith("\n"))
        header, rows = parse(text)
        self.assertTrue(all(len(row) == len(header) for row in rows))
        self.assertGreater(len(rows), 300)
        self.assertNotIn("box.csv", self.names())

    def test_disk_that_fills_up_under_a_checkpoint_keeps_the_one_before(self):
        settings = ("--set", "integrator.end_time=100", "--set", "output.every=2000")
        self.succeed("run", "box.nml", "--output", "whole.csv", *settings)
        self.fail_with(3, "run", "box.nml", "--checkpoint", "ck", "--max-steps", "3000", *settings)
        with open(self.path("ck"), "rb") as file:
            before = file.read()

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) - 1, len(before) - 1))
        self.fail_with(4, "run", "box.nml", "--resume", "ck", *settings, preexec_fn=limit,
                       says=["cannot write checkpoint ck", "too large", "--resume ck"])
        with open(self.path("ck"), "rb") as file:
            self.assertEqual(file.read(), before)
        self.assertNotIn("ck.tmp", self.names())
        self.succeed("run", "box.nml", "--resume", "ck", *settings)
        self.assertEqual(self.read("box.csv"), self.read("whole.csv"))

    def test_a_folder_that_vanishes_in_mid_run_is_told_at_the_end(self):
        os.mkdir(self.path("gone"))
        command = [self.program, "run", "box.nml", "--quiet", "--output", "gone/box.csv", "--set",
                   "integrator.end_time=300"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
            self.wait_for("gone/box.csv.partial", 100000)
            os.rename(self.path("gone"), self.path("elsewhere"))
            _, said = run.communicate(timeout=PATIENCE)
        self.assertEqual(run.returncode, 4)
        self.assertEqual(said.count("\n"), 1, said)
        self.assertIn("no such file", said.lower())
        self.assertEqual(os.listdir(self.path("elsewhere")), ["box.csv.partial"])

    def test_a_scene_that_vanishes_in_mid_run_is_not_missed(self):
        command = [self.program, "run", "box.nml", "--quiet", "--set", "integrator.end_time=300"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
            self.wait_for("box.csv.partial", 100000)
            os.rename(self.path("box.nml"), self.path("moved.nml"))
            self.assertEqual(run.communicate(timeout=PATIENCE)[1], "")
        self.assertEqual(run.returncode, 0)
        self.succeed("run", "moved.nml", "--output", "again.csv", "--quiet", "--set", "integrator.end_time=300")
        self.assertEqual(self.read("box.csv"), self.read("again.csv"))

    def test_missing_folder(self):
        self.fail_with(4, "run", "box.nml", "--output", "nowhere/box.csv", says=["nowhere/box.csv", "no such file"])

    def test_folder_as_output(self):
        os.mkdir(self.path("folder"))
        self.fail_with(4, "run", "box.nml", "--output", "folder", says=["folder"])
        self.fail_with(4, "run", "box.nml", "--output", "box.nml/box.csv", says=["not a directory"])

    @unittest.skipIf(os.geteuid() == 0, "root writes everywhere")
    def test_folder_and_file_that_must_not_be_written(self):
        self.write("kept.csv", "t,q0\n")
        os.chmod(self.path("kept.csv"), 0o444)
        self.fail_with(4, "run", "box.nml", "--output", "kept.csv", says=["permission"])
        os.mkdir(self.path("closed"), 0o555)
        self.fail_with(4, "run", "box.nml", "--output", "closed/box.csv", says=["permission"])

    def test_a_second_run_of_the_same_output_is_refused(self):
        with open(self.path("box.csv.partial"), "w", encoding="utf-8") as other:
            other.write("t,q0\n0,1\n")
            other.flush()
            fcntl.flock(other, fcntl.LOCK_EX)
            self.fail_with(4, "run", "box.nml", says=["box.csv", "another run"])
            self.assertEqual(self.read("box.csv.partial"), "t,q0\n0,1\n")
        self.succeed("run", "box.nml")

    def test_remains_of_a_failed_run_are_replaced(self):
        self.write("box.csv.partial", "x" * 1000000)
        self.succeed("run", "box.nml")
        self.assertEqual(len(self.history("box.csv")[1]), 51)
        self.assertNotIn("box.csv.partial", self.names())

    def test_a_closed_pipe_ends_the_run_quietly(self):
        command = [self.program, "run", "box.nml", "--output", "-", "--quiet", "--set", "integrator.end_time=1000"]
        with subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
            run.stdout.readline()
            run.stdout.close()
            self.assertEqual(run.stderr.read(), b"")
            run.wait(timeout=PATIENCE)
        self.assertEqual(run.returncode, -signal.SIGPIPE)


class FailedRuns(CommandLineTest):
    def test_a_run_beyond_the_step_limit_keeps_its_rows(self):
        self.fail_with(3, "run", "box.nml", "--max-steps", "10",
                       says=["box.nml", "t = 0.1 s", "10 steps", "box.csv.partial", "11 rows"])
        header, rows = self.history("box.csv.partial")
        self.assertEqual(len(rows), 11)
        self.assertTrue(all(len(row) == len(header) for row in rows))
        self.assertNotIn("box.csv", self.names())

    def test_quiet_does_not_hide_errors(self):
        self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--quiet", says=["steps"])

    def test_enough_steps_are_enough(self):
        self.succeed("run", "box.nml", "--max-steps", "50")

    def test_a_history_beyond_the_limit_of_rows_keeps_the_rows_allowed(self):
        for settings in ((), ("--set", "output.times=0,0.1,0.2,0.3,0.4,0.5"), ("--set", "integrator.accuracy=1e-6")):
            with self.subTest(settings=settings):
                self.fail_with(3, "run", "box.nml", "--max-rows", "4", *settings,
                               says=["box.nml", "more rows than allowed", "box.csv.partial", "4 rows"])
                self.assertEqual(len(self.history("box.csv.partial")[1]), 4)
        self.succeed("run", "box.nml", "--max-rows", "51")
        self.assertEqual(len(self.history("box.csv")[1]), 51)

    def test_events_beyond_the_limit_of_rows_end_the_run(self):
        event = ("--set", "event.name=node", "--set", "event.when=q0", "--set", "event.crosses=0", "--set", "integrator.end_time=4")
        self.succeed("run", "box.nml", *event)
        times = [row[0] for row in self.history("box.csv")[1]]
        found = len(self.read("box.events.csv").splitlines()) - 1
        self.assertGreater(found, 3)
        few = ("--set", "output.every=400", "--max-rows")
        self.fail_with(3, "run", "box.nml", *event, *few, str(found - 1), says=["events", "more rows than allowed"])
        self.assertEqual(len(self.read("box.events.csv.partial").splitlines()) - 1, found - 1)
        self.succeed("run", "box.nml", *event, *few, str(found))
        self.assertLess(found, len(times))

    def test_a_resumed_run_counts_the_rows_before_it(self):
        self.fail_with(3, "run", "box.nml", "--checkpoint", "ck", "--max-steps", "20")
        self.fail_with(3, "run", "box.nml", "--resume", "ck", "--max-rows", "30", says=["30 rows"])

    def test_a_killed_run_leaves_no_file_that_looks_complete(self):
        command = [self.program, "run", "box.nml", "--quiet", "--set", "integrator.end_time=1e6", "--set", "output.every=1"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE) as run:
            self.wait_for("box.csv.partial", 200000)
            run.kill()
            run.wait(timeout=PATIENCE)
        self.assertEqual(run.returncode, -signal.SIGKILL)
        self.assertEqual(self.names(), ["box.csv.partial", "box.nml", "top.nml"])


if __name__ == "__main__":
    unittest.main()

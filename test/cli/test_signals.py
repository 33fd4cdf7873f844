"""Signals: a run ends in order, keeps its rows, says so in one line, and dies by the signal."""
import array
import fcntl
import os
import re
import signal
import subprocess
import termios
import time
import unittest

from support import PATIENCE, CommandLineTest, is_asleep, one_of, parse, wait_until

ENDLESS = ("--set", "integrator.end_time=1e6", "--set", "output.every=1")


def watches_signals(run):
    """The program has its handler for SIGTERM: a signal before that moment just ends it."""
    with open(f"/proc/{run.pid}/status", encoding="ascii") as status:
        caught = [line.split()[1] for line in status if line.startswith("SigCgt")]
    return bool(caught) and bool(int(caught[0], 16) >> signal.SIGTERM - 1 & 1)


class SignalTest(CommandLineTest):
    def start(self, *arguments, **options):
        """A run under way, its standard error as text."""
        run = subprocess.Popen([self.program, *arguments], cwd=self.folder, stderr=subprocess.PIPE, text=True, **options)
        self.addCleanup(run.stderr.close)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        wait_until(lambda: watches_signals(run) or run.poll() is not None)
        return run

    def ends_by(self, run, number, says):
        """The run dies by the signal after one line that holds all of `says`."""
        said = run.stderr.read()
        self.assertEqual(run.wait(timeout=PATIENCE), -number, said)
        self.assertEqual(said.count("\n"), 1, said)
        for text in says:
            self.assertIn(text, said)
        return said


class Runs(SignalTest):
    def test_each_signal_keeps_whole_rows_and_is_named(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            run = self.start("run", "box.nml", *ENDLESS)
            self.wait_for("box.csv.partial", 200000)
            run.send_signal(number)
            said = self.ends_by(run, number, ["box.nml: stopped by " + number.name, "t = ", "box.csv.partial"])
            text = self.read("box.csv.partial")
            self.assertTrue(text.endswith("\n"))
            header, rows = parse(text)
            self.assertTrue(all(len(row) == len(header) for row in rows))
            self.assertIn(f"kept {len(rows)} rows up to t = {rows[-1][0]:.9g} s", said)
            self.assertNotIn("box.csv", self.names())
            os.remove(self.path("box.csv.partial"))

    def test_a_shell_sees_the_conventional_status(self):
        for number, status in ((2, 130), (15, 143), (1, 129)):
            command = ["timeout", "--preserve-status", "-s", str(number), "0.1", self.program, "run", "box.nml", *ENDLESS]
            shell = " ".join(f"'{word}'" for word in command)
            done = subprocess.run(["sh", "-c", shell], cwd=self.folder, capture_output=True, timeout=PATIENCE, check=False)
            self.assertEqual(done.returncode, status, done.stderr)

    def test_runs_with_steps_by_their_error(self):
        self.write("top.nml", self.read("top.nml").replace("time_step = 0.005", "local_tolerance = 1e-8"))
        run = self.start("run", "top.nml", *ENDLESS)
        self.wait_for("top.csv.partial", 200000)
        run.send_signal(signal.SIGINT)
        self.ends_by(run, signal.SIGINT, ["top.nml: stopped by SIGINT", "top.csv.partial"])
        self.assertTrue(self.read("top.csv.partial").endswith("\n"))

    def test_a_last_checkpoint_is_written(self):
        settings = ("--set", "integrator.end_time=200")
        self.succeed("run", "box.nml", "--output", "whole.csv", "--quiet", *settings)
        arguments = ["--output", "part.csv", "--checkpoint", "ck", "--every-seconds", "1000"]
        size = 0
        for _ in range(3):
            run = self.start("run", "box.nml", "--quiet", *arguments, *settings)
            self.wait_for("part.csv.partial", size + 300000)
            run.send_signal(signal.SIGTERM)
            self.ends_by(run, signal.SIGTERM, ["to continue: --resume ck"])
            size = os.path.getsize(self.path("part.csv.partial"))
            arguments = ["--resume", "ck"]
        self.succeed("run", "box.nml", "--quiet", *arguments, *settings)
        self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_trial_runs(self):
        self.write("top.nml", self.read("top.nml").replace("time_step = 0.005", "accuracy = 1e-9"))
        run = self.start("run", "top.nml", *ENDLESS)
        run.send_signal(signal.SIGINT)
        self.ends_by(run, signal.SIGINT, ["top.nml", "trial run", "SIGINT"])
        self.assertEqual(self.names(), ["box.nml", "top.nml"])

    def test_signals_that_are_ignored_stay_ignored(self):
        run = self.start("run", "box.nml", *ENDLESS, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.wait_for("box.csv.partial", 100000)
        run.send_signal(signal.SIGHUP)
        self.wait_for("box.csv.partial", os.path.getsize(self.path("box.csv.partial")) + 1000000)
        run.send_signal(signal.SIGTERM)
        self.ends_by(run, signal.SIGTERM, ["SIGTERM"])

    @one_of(3)
    def test_a_signal_sent_twice_at_once_is_one_request(self):
        """As timeout(1) does, within 0.2 s."""
        run = self.start("run", "box.nml", *ENDLESS)
        self.wait_for("box.csv.partial", 100000)
        run.send_signal(signal.SIGTERM)
        run.send_signal(signal.SIGTERM)
        self.ends_by(run, signal.SIGTERM, ["stopped by SIGTERM", "box.csv.partial"])


class BlockedPipes(SignalTest):
    def setUp(self):
        super().setUp()
        self.reader, self.writer = os.pipe()
        self.addCleanup(os.close, self.reader)
        self.run_blocked = self.start("run", "box.nml", "--output", "-", *ENDLESS, stdout=self.writer)
        os.close(self.writer)
        wait_until(lambda: self.pipe_is_full() and is_asleep(self.run_blocked))

    def pipe_is_full(self):
        waiting = array.array("i", [0])
        fcntl.ioctl(self.reader, termios.FIONREAD, waiting)
        return waiting[0] > 60000

    def test_a_signal_ends_a_write_that_waits(self):
        self.run_blocked.send_signal(signal.SIGINT)
        self.ends_by(self.run_blocked, signal.SIGINT, ["box.nml: stopped by SIGINT"])

    @one_of(3)
    def test_a_second_signal_kills_at_once(self):
        """One that comes more than 0.2 s after the first; the program waits 1 s for the reader."""
        self.run_blocked.send_signal(signal.SIGINT)
        time.sleep(0.4)
        self.run_blocked.send_signal(signal.SIGINT)
        self.assertEqual(self.run_blocked.stderr.read(), "")
        self.assertEqual(self.run_blocked.wait(timeout=PATIENCE), -signal.SIGINT)

    @one_of(3)
    def test_a_reader_that_goes_on_gets_all_rows(self):
        """The program waits 1 s for the reader."""
        self.run_blocked.send_signal(signal.SIGINT)
        text = b""
        while block := os.read(self.reader, 65536):
            text += block
            self.assertLess(len(text), 10_000_000, "the run goes on")
        self.ends_by(self.run_blocked, signal.SIGINT, ["box.nml: stopped by SIGINT"])
        self.assertTrue(text.endswith(b"\n"))
        header, rows = parse(text.decode())
        self.assertTrue(all(len(row) == len(header) for row in rows))
        self.assertEqual([round(row[0], 9) for row in rows], [round(0.01*i, 9) for i in range(len(rows))])


class OtherCommands(SignalTest):
    def stop_study(self):
        """Stops a study after the first run of each method and before its end: its table, and standard error. On a machine that
        has not come so far by then, or is at the end, it is stopped later, or has more to do."""
        evaluations, delay = 3_000_000, 0.2
        for _ in range(20):
            run = self.start("cost", "top.nml", "--evaluations", str(evaluations), "--csv", "kept.csv", stdout=subprocess.PIPE)
            time.sleep(delay)
            run.send_signal(signal.SIGINT)
            with run.stdout:
                text = run.stdout.read()
            if run.wait() == 0:
                evaluations *= 4
                self.write("kept.csv", "method,order,\n")
            elif re.search("taylor, until the study was stopped\n.*E-", text):
                break
            else:
                delay *= 2
        return text, self.ends_by(run, signal.SIGINT, ["top.nml: stopped by SIGINT"])

    def test_a_fifo_without_reader(self):
        os.mkfifo(self.path("fifo"))
        run = self.start("run", "box.nml", "--output", "fifo")
        wait_until(lambda: is_asleep(run))
        run.send_signal(signal.SIGTERM)
        self.ends_by(run, signal.SIGTERM, ["box.nml: stopped by SIGTERM"])

    def test_a_plot_leaves_no_partial_files(self):
        self.succeed("run", "box.nml", "--quiet")
        os.mkdir(self.path("bin"))
        # It draws when it is told to.
        self.write("bin/gnuplot", '#!/bin/sh\necho >waits\nwhile [ ! -e go ]; do sleep 0.01; done\necho "<svg></svg>" >"$3"\n')
        os.chmod(self.path("bin/gnuplot"), 0o700)
        plot = self.start("plot", "box.csv", env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        wait_until(lambda: os.path.exists(self.path("waits")))
        plot.send_signal(signal.SIGTERM)
        self.write("go", "")
        self.assertEqual(plot.wait(timeout=PATIENCE), -signal.SIGTERM)
        self.assertEqual([name for name in self.names() if "partial" in name], [])

    def test_a_fit_leaves_no_files(self):
        self.write("box.nml", self.read("box.nml") + "&free key = 'initial.angular_velocity' /\n"
                   "&measurement file = 'gyro.csv', columns = 'omega1', sigma = 1e-6 /\n")
        self.write("gyro.csv", "t,omega1\n" + "".join(f"{0.5*i},{0.1*i % 1}\n" for i in range(1, 400)))
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", "#!/bin/sh\nexit 1\n")
        os.chmod(self.path("bin/gnuplot"), 0o700)
        before = self.names()
        for number in (signal.SIGINT, signal.SIGTERM):
            fit = self.start("fit", "box.nml", "--plot", "fit.svg", "--set", "integrator.end_time=1000", "--set", "integrator.time_step=1e-4",
                             stdout=subprocess.DEVNULL,
                             env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
            wait_until(lambda: "fit.svg.partial" in self.names() or fit.poll() is not None)
            fit.send_signal(number)
            self.ends_by(fit, number, [f"box.nml: stopped by {number.name}; nothing was written"])
            self.assertEqual(self.names(), before)

    def test_a_cost_study_shows_what_it_has(self):
        self.write("kept.csv", "method,order,\n")
        run = self.start("cost", "top.nml", "--evaluations", "200000000", "--csv", "kept.csv", "--set", "integrator.end_time=1e7")
        run.send_signal(signal.SIGINT)
        self.ends_by(run, signal.SIGINT, ["top.nml: stopped by SIGINT; nothing was written"])
        self.assertEqual(self.names(), ["box.nml", "kept.csv", "top.nml"])
        text, said = self.stop_study()
        self.assertRegex(said, r"top\.nml: stopped by SIGINT after \d+ runs; kept in kept\.csv\.partial")
        self.assertIn("cheapest first", text)
        rows = self.read("kept.csv.partial").splitlines()
        self.assertGreater(len(rows), 2)
        self.assertEqual({row.count(",") for row in rows}, {14})
        self.assertEqual(self.read("kept.csv"), "method,order,\n")
        self.assertEqual(self.names(), ["box.nml", "kept.csv", "kept.csv.partial", "top.nml"])


if __name__ == "__main__":
    unittest.main()

"""Where rows and checkpoints go: symbolic links stay links, and every name that the folder admits can be written."""
import os
import stat
import unittest

from support import CommandLineTest, in_turn

# The longest name of a file, bytes, in the folder of a test.
LONGEST = os.pathconf("/tmp", "PC_NAME_MAX")


# Leaves the inertia of box.nml to others.
SHAPELESS = ("--unset", "body.shape", "--unset", "body.size")


class Links(CommandLineTest):
    def test_a_link_to_a_file_that_is_not_there_yet_stays_a_link(self):
        os.mkdir(self.path("disk"))
        os.symlink("disk/real.csv", self.path("box.csv"))
        self.succeed("run", "box.nml")
        self.assertEqual(os.readlink(self.path("box.csv")), "disk/real.csv")
        self.assertEqual(os.listdir(self.path("disk")), ["real.csv"])
        self.assertEqual(len(self.history("disk/real.csv")[1]), 51)

    def test_a_chain_of_links_is_followed_to_its_end(self):
        os.mkdir(self.path("disk"))
        os.symlink(self.path("disk/second"), self.path("first"))
        os.symlink("../real.csv", self.path("disk/second"))
        self.succeed("run", "box.nml", "--output", "first")
        self.assertTrue(os.path.islink(self.path("first")) and os.path.islink(self.path("disk/second")))
        self.assertEqual(len(self.history("real.csv")[1]), 51)
        self.assertEqual(os.listdir(self.path("disk")), ["second"])

    def test_rows_of_an_incomplete_run_are_beside_the_file_that_the_link_means(self):
        os.mkdir(self.path("disk"))
        os.symlink("disk/real.csv", self.path("box.csv"))
        self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--checkpoint", "ck",
                       says=["disk/real.csv.partial", "11 rows"])
        self.assertEqual(os.listdir(self.path("disk")), ["real.csv.partial"])
        self.succeed("run", "box.nml", "--resume", "ck")
        self.succeed("run", "box.nml", "--output", "plain.csv")
        self.assertEqual(self.read("disk/real.csv"), self.read("plain.csv"))
        self.assertTrue(os.path.islink(self.path("box.csv")))

    def test_links_that_lead_nowhere_are_told_before_the_run(self):
        os.symlink("nowhere/real.csv", self.path("lost.csv"))
        self.fail_with(4, "run", "box.nml", "--output", "lost.csv", says=["lost.csv", "no such file"])
        os.symlink("b.csv", self.path("a.csv"))
        os.symlink("a.csv", self.path("b.csv"))
        self.fail_with(4, "run", "box.nml", "--output", "a.csv", says=["a.csv", "symbolic links"])
        self.assertTrue(all(os.path.islink(self.path(name)) for name in ("lost.csv", "a.csv", "b.csv")))

    def test_a_checkpoint_goes_where_its_link_leads(self):
        os.mkdir(self.path("disk"))
        os.symlink("disk/ck", self.path("link"))
        self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--checkpoint", "link", says=["--resume link"])
        self.assertEqual(os.listdir(self.path("disk")), ["ck"])
        # Written anew while it is there.
        self.fail_with(3, "run", "box.nml", "--max-steps", "20", "--resume", "link", says=["--resume link"])
        self.assertEqual(os.readlink(self.path("link")), "disk/ck")
        self.succeed("run", "box.nml", "--resume", "link")
        self.assertEqual(os.listdir(self.path("disk")), [])
        self.assertEqual(os.readlink(self.path("link")), "disk/ck")


class Formats(CommandLineTest):
    def test_names_of_other_formats_are_refused(self):
        for name in ("r.npy", "r.HDF5", "a/b.json"):
            for command in ("run", "check"):
                self.fail_with(2, command, "box.nml", "--set", "output.file=" + name,
                               says=(name, "histories are CSV", "box.csv"))
            self.fail_with(2, "run", "box.nml", "--output", name, says=("--output " + name, "histories are CSV", "box.csv"))
        self.assertEqual(self.names(), ["box.nml", "top.nml"])
        for name in ("r.txt", "npy", "r.npy.csv"):
            self.succeed("run", "box.nml", "--output", name)


class Kinds(CommandLineTest):
    """What is there is replaced only by a file of the same kind."""

    SWEEP = "&ensemble members = 3 /\n&vary key = 'body.mass', distribution = 'uniform', low = 11.0, high = 13.0 /\n"

    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def kept(self, name, *command, says=()):
        """The command is refused in one line and leaves all files as they were."""
        before = {each: self.bytes_of(each) for each in self.names()}
        done = self.fail_with(2, *command, says=(name, *says))
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual({each: self.bytes_of(each) for each in self.names()}, before)

    def make_files(self):
        """A file of every kind but pictures and pages."""
        with open(self.path("box.nml"), encoding="utf-8") as file:
            self.write("many.nml", file.read() + self.SWEEP + "&event name = 'turn', when = 'omega1', crosses = 0.0 /\n")
        self.succeed("run", "many.nml", "--output", "history")
        self.succeed("sweep", "many.nml", "--output", "rows", "--csv", "members")
        self.succeed("sweep", "many.nml", "--output", "means", "--set", "ensemble.rows=none")
        self.succeed("cost", "box.nml", "--evaluations", "300000", "--csv", "costs")
        self.fail_with(3, "run", "many.nml", "--output", "other", "--checkpoint", "ck", "--max-steps", "3")
        self.write("notes", "to do\n")
        self.write("table", "t (s),x (N m),y (N m),z (N m)\n0,0,0,0\n1,0,0,0\n")

    def test_no_command_replaces_a_file_of_another_kind(self):
        self.make_files()
        kinds = {"history": ("run", "many.nml", "--output"), "history.events.csv": ("run", "many.nml", "--set"),
                 "rows": ("sweep", "many.nml", "--output"), "members": ("sweep", "many.nml", "--output", "r.npy", "--csv"),
                 "means": ("sweep", "many.nml", "--set", "ensemble.rows=none", "--output"),
                 "costs": ("cost", "box.nml", "--evaluations", "300000", "--csv")}
        others = [*kinds, "rows.txt", "ck", "other.partial", "notes", "top.nml"]
        for turn, (kind, command) in enumerate(kinds.items()):
            for number, name in enumerate(others, turn):
                if in_turn(number) and name != kind and (name, kind) != ("other.partial", "history"):
                    self.kept(name, *command, f"output.events='{name}'" if command[-1] == "--set" else name)
        for name in others:
            if name not in ("history", "other.partial"):
                self.kept(name, "sweep", "many.nml", "--member", "2", "--output", name)

    def test_what_a_command_writes_beside_its_output_replaces_nothing_else(self):
        self.make_files()
        self.write("r.npy.txt", "to do\n")
        self.kept("r.npy.txt", "sweep", "many.nml", "--output", "r.npy")
        self.write("s.member2.csv", "to do\n")
        self.kept("s.member2.csv", "sweep", "many.nml", "--output", "s.npy", "--set", "ensemble.histories=2")
        self.write("h.events.csv", "to do\n")
        self.kept("h.events.csv", "run", "many.nml", "--output", "h.csv")
        # Rows of an interrupted sweep.
        os.rename(self.path("rows"), self.path("h.partial"))
        self.kept("h.partial", "run", "box.nml", "--output", "h")

    def test_a_member_alone_leaves_the_rows_of_the_sweep(self):
        self.make_files()
        self.succeed("sweep", "many.nml", "--output", "o.npy")
        self.kept("o.npy", "sweep", "many.nml", "--output", "o.npy", "--member", "2", says=("histories are CSV",))
        self.kept("o.npy", "sweep", "many.nml", "--output", "o.npy", "--csv", "o.npy")
        self.kept("new.rows", "sweep", "many.nml", "--output", "new.rows", "--csv", "./new.rows", says=("where the rows go",))

    def test_tables_are_not_written_over(self):
        self.write("t.csv", "t (s),x (N m),y (N m),z (N m)\n0,0,0,0\n1,0,0,0\n")
        for name in ("t.csv", "./t.csv"):
            self.kept(name, "run", "box.nml", "--set", "torque.table='t.csv'", "--output", name, says=("table of the scene",))
        self.write("times.csv", "t (s)\n0\n0.1\n")
        self.kept("times.csv", "run", "box.nml", "--set", "output.times_file='times.csv'", "--output", "times.csv")
        self.write("i.csv", "t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,5,20,17\n1,5,21,18\n")
        self.kept("i.csv", "run", "box.nml", *SHAPELESS, "--set", "body.inertia_table=i.csv", "--output", "i.csv",
                  says=("table of the scene",))
        self.write("c.csv", "t (s),x (m),y (m),z (m)\n0,0,0,0.1\n1,0,0,0.2\n")
        self.kept("c.csv", "run", "top.nml", "--unset", "body.center_of_mass", "--set", "body.center_of_mass_table=c.csv",
                  "--output", "c.csv", says=("table of the scene",))

    def test_an_export_leaves_the_files_of_its_scene(self):
        self.succeed("run", "box.nml", "--output", "box.csv")
        labels = ("--set", "scene.epoch=2026-01-01", "--set", "scene.time_system=UTC", "--set", "scene.space_frame=ICRF")
        self.succeed("export", "box.csv", "--scene", "box.nml", *labels, "--aem", "there.aem")
        self.kept("there.aem", "export", "box.csv", "--scene", "box.nml", *labels, "--set", "frame.attitude=there.aem",
                  "--aem", "there.aem", says=("the attitude of a frame",))

    def test_pictures_and_pages_replace_their_like_only(self):
        self.succeed("run", "box.nml")
        for name in ("a.svg", "a.png", "a.html"):
            self.write(name, "t,q0\n")
        for name in ("a.svg", "a.png"):
            self.kept(name, "plot", "box.csv", "--output", name, says=("a history, not a", "picture"))
            self.kept(name, "run", "box.nml", "--plot", name)
            self.kept(name, "cost", "box.nml", "--plot", name, "--evaluations", "300000")
        os.mkdir(self.path("bin"))
        self.write("bin/python3", "#!/bin/sh\nexit 0\n")
        os.chmod(self.path("bin/python3"), stat.S_IRWXU)
        path = {**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]}
        self.fail_with(2, "view", "box.nml", "--output", "a.html", says=("a.html", "not a web page"), env=path)
        self.write("box.html", "to do\n")
        self.fail_with(2, "view", "box.nml", says=("box.html", "not a web page"), env=path)
        self.write("box.html", "<!DOCTYPE html>\n")
        self.succeed("view", "box.nml", env=path)


class LongNames(CommandLineTest):
    def test_names_up_to_the_longest_are_written(self):
        self.succeed("run", "box.nml", "--output", "plain.csv")
        for length in (LONGEST - 9, LONGEST - 8, LONGEST - 7, LONGEST - 1, LONGEST):
            name = "n" * (length - 4) + ".csv"
            self.succeed("run", "box.nml", "--output", name)
            self.assertEqual(self.read(name), self.read("plain.csv"))
            self.assertEqual(self.names(), sorted(["box.nml", "top.nml", "plain.csv", name]))
            os.remove(self.path(name))

    def test_a_name_that_is_too_long_is_refused_before_the_run(self):
        self.fail_with(4, "run", "box.nml", "--output", "n" * (LONGEST + 1), says=["too long"])
        self.fail_with(4, "run", "box.nml", "--checkpoint", "n" * (LONGEST + 1), says=["too long"])
        self.assertNotIn("box.csv", self.names())

    def test_long_names_that_begin_alike_are_kept_apart(self):
        names = ["n" * (LONGEST - 1) + last for last in "ab"]
        for name in names:
            self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--output", name, says=[".partial"])
        kept = [name for name in self.names() if name.endswith(".partial")]
        self.assertEqual(len(kept), 2)
        self.assertTrue(all(len(name) <= LONGEST for name in kept))

    def test_a_run_with_long_names_goes_on(self):
        # Letters of two bytes are not cut through.
        rows, checkpoint = "ß" * (LONGEST // 2), "c" * LONGEST
        said = self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--output", rows, "--checkpoint", checkpoint)
        partial = [name for name in self.names() if name.endswith(".partial")]
        self.assertEqual(len(partial), 1)
        self.assertRegex(partial[0], "^ß+-[0-9A-F]{16}[.]partial$")
        self.assertIn(partial[0], said.stderr)
        self.succeed("run", "box.nml", "--resume", checkpoint)
        self.succeed("run", "box.nml", "--output", "plain.csv")
        self.assertEqual(self.read(rows), self.read("plain.csv"))
        self.assertEqual(self.names(), sorted(["box.nml", "top.nml", "plain.csv", rows]))

    def test_a_picture_with_the_longest_name(self):
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", "#!/bin/sh\n[ -s \"$2\" ] && echo drawn >\"$3\"\n")
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        name = "p" * (LONGEST - 4) + ".svg"
        self.succeed("cost", "box.nml", "--evaluations", "500000", "--plot", name,
                     env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        self.assertEqual(self.read(name), "drawn\n")
        self.assertEqual(self.names(), sorted(["bin", "box.nml", name, "top.nml"]))

    def test_names_that_are_not_too_long_keep_their_partial_name(self):
        name = "n" * (LONGEST - len(".partial"))
        self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--output", name, says=[name + ".partial"])
        self.assertIn(name + ".partial", self.names())


if __name__ == "__main__":
    unittest.main()

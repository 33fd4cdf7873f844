"""nutate view SCENE, where Python has not what is needed. python/tests/test_view.py has the rest."""
import os
import shutil
import stat
import subprocess
import unittest

from support import CommandLineTest


class WithoutPython(CommandLineTest):
    def test_what_is_missing_is_said(self):
        os.mkdir(self.path("bin"))
        self.write("bin/python3", "#!/bin/sh\nexit 1\n")
        os.chmod(self.path("bin/python3"), stat.S_IRWXU)
        self.fail_with(4, "view", "box.nml", says=("box.nml", "no python3 beside the program or on PATH has the module nutate"),
                       env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        self.assertEqual(self.names(), ["bin", "box.nml", "top.nml"])

    def test_a_python_beside_the_program_comes_first(self):
        for folder in ("bin", "other"):
            os.mkdir(self.path(folder))
            self.write(folder + "/python3", f"#!/bin/sh\necho {folder} $PYTHONPATH \"$@\" >> '{self.path('calls')}'\n")
            os.chmod(self.path(folder + "/python3"), stat.S_IRWXU)
        shutil.copy(self.program, self.path("bin/nutate"))
        environment = {**os.environ, "PATH": self.path("other") + os.pathsep + os.environ["PATH"]}
        environment.pop("PYTHONPATH", None)
        command = (self.path("bin/nutate"), "view", "box.nml", "--set", "body.mass=3")
        subprocess.run(command, cwd=self.folder, env=environment, check=True)
        self.assertEqual(self.read("calls").splitlines()[-1], "bin -m nutate.view --output=box.html --set=body.mass=3 -- box.nml")
        subprocess.run((*command[:3], "--from", "2.5"), cwd=self.folder, env=environment, check=True)
        self.assertIn(" -m nutate.view --output=box.html --from=2.5 -- box.nml", self.read("calls").splitlines()[-1])
        # One that lacks the module is passed over.
        self.write("bin/python3", "#!/bin/sh\nexit 1\n")
        subprocess.run(command, cwd=self.folder, env=environment, check=True)
        self.assertIn("other -m nutate.view", self.read("calls").splitlines()[-1])
        # The module that was installed with the program is found.
        self.write("other/python3", f"#!/bin/sh\necho $PYTHONPATH \"$@\" >> '{self.path('calls')}'\n"
                   "case $PYTHONPATH in */bin/../share/nutate/python) exit 0;; esac\nexit 1\n")
        subprocess.run(command, cwd=self.folder, env=environment, check=True)
        self.assertIn("/bin/../share/nutate/python -m nutate.view", self.read("calls").splitlines()[-1])

    def test_it_is_one_of_the_commands(self):
        self.assertIn("nutate view SCENE", self.succeed("--help").stdout)
        page = self.succeed("help", "view").stdout
        for word in ("--output", "--set", "--unset", "polhode", "python3"):
            self.assertIn(word, page)
        self.fail_with(2, "view", says=("there is no scene",))
        self.fail_with(2, "view", "box.nml", "--from", "soon", says=("--from 'soon' is not a time",))
        self.fail_with(2, "view", "box.nml", "--quiet", says=("--quiet",))


if __name__ == "__main__":
    unittest.main()

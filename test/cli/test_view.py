"""nutate view SCENE, where Python has not what is needed. python/tests/test_view.py has the rest."""
import os
import stat
import unittest

from support import CommandLineTest


class WithoutPython(CommandLineTest):
    def test_what_is_missing_is_said(self):
        os.mkdir(self.path("bin"))
        self.write("bin/python3", "#!/bin/sh\nexit 1\n")
        os.chmod(self.path("bin/python3"), stat.S_IRWXU)
        self.fail_with(4, "view", "box.nml", says=("box.nml", "python3 has no module nutate"),
                       env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        self.assertEqual(self.names(), ["bin", "box.nml", "top.nml"])

    def test_it_is_one_of_the_commands(self):
        self.assertIn("nutate view SCENE", self.succeed("--help").stdout)
        page = self.succeed("help", "view").stdout
        for word in ("--output", "--set", "--unset", "polhode", "python3"):
            self.assertIn(word, page)
        self.fail_with(2, "view", says=("there is no scene",))
        self.fail_with(2, "view", "box.nml", "--quiet", says=("--quiet",))


if __name__ == "__main__":
    unittest.main()

"""Malformed scenes: one clear line, exit status 2, nothing written.

Every file in `malformed/` begins with a comment `! expect: LINE: fragment of the message`, or `! expect: TABLE.csv:LINE: ...`
or `MESSAGE.aem` where the error is in the file of that name beside it. The program under test is
named by the environment variable NUTATE (default: `nutate` on the search path).
"""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from support import PATIENCE, in_turn

NUTATE = os.path.abspath(os.environ["NUTATE"]) if "NUTATE" in os.environ else "nutate"
HERE = pathlib.Path(__file__).resolve().parent
MALFORMED = HERE / "malformed"
BOX = HERE.parent.parent / "scenes" / "box.nml"

# Settings of the command line and the words for them.
SETTINGS = {
    "no_equals": ("body.mass", "'body.mass' is not a setting (expected GROUP.KEY=VALUE)"),
    "no_group": ("mass=1.0", "'mass=1.0' is not a setting"),
    "unknown_group": ("bdy.mass=1.0", "unknown group 'bdy'"),
    "unknown_key": ("body.mas=1.0", "nearest: mass)"),
    "no_value": ("body.mass=", "mass has no value (expected a number > 0)"),
    "two_settings": ("body.mass=1.0 density=2.0", "'density' follows the value of mass"),
    "closing_slash": ("body.mass=1.0 /", "'/' follows the value of mass"),
    "overflow": ("integrator.time_step=1e999", "'1e999' is too large"),
    "two_that_say_the_same": ("body.inertia=1.0,1.0,1.0", "shape and inertia in &body exclude each other"),
    "incomplete_effect": ("spring.stiffness=1.0", "&spring lacks"),
    "lines": ("scene.title='one\ntwo'", "a string is not closed"),
}


class OneLine(unittest.TestCase):
    """Runs nutate where it has nothing but the scene, and looks at all it leaves."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def complaint(self, command, scene, *options):
        """The only line on standard error of a command that must fail with exit status 2."""
        before = sorted(os.listdir(self.folder.name))
        result = subprocess.run(
            [NUTATE, command, scene, *options], cwd=self.folder.name, capture_output=True, timeout=PATIENCE, check=False
        )
        message = result.stderr.decode("utf-8", "replace")
        self.assertEqual(result.returncode, 2, message)
        self.assertEqual(result.stdout, b"")
        self.assertTrue(message.endswith("\n"), repr(message))
        self.assertEqual(message.count("\n"), 1, message)
        self.assertTrue(message[:-1].isprintable(), repr(message))
        self.assertEqual(sorted(os.listdir(self.folder.name)), before)
        return message

    def check_file(self, path, command):
        first = path.read_bytes().split(b"\n")[0].decode().strip()
        file, line, fragment = re.fullmatch(r"! expect: (?:(\w+\.(?:csv|aem)):)?(\d+): (.*)", first).groups()
        shutil.copy(path, self.folder.name)
        for suffix in (".csv", ".aem"):
            if path.with_suffix(suffix).exists():
                shutil.copy(path.with_suffix(suffix), self.folder.name)
        message = self.complaint(command, path.name)
        self.assertTrue(message.startswith(f"{file or path.name}:{line}: "), f"{message!r} is not about line {line}")
        self.assertIn(fragment, message)

    def check_setting(self, setting, fragment):
        shutil.copy(BOX, self.folder.name)
        message = self.complaint("run", BOX.name, "--set", setting)
        self.assertTrue(message.startswith("--set: "), message)
        self.assertIn(fragment, message)

    def test_missing_file_is_named(self):
        for command in ("run", "check"):
            self.assertTrue(self.complaint(command, "absent.nml").startswith("absent.nml: cannot be read ("))

    def test_folder_is_no_scene(self):
        for command in ("run", "check"):
            self.assertTrue(self.complaint(command, ".").startswith(".: cannot be read ("))
            self.assertIn("the name of the scene is blank", self.complaint(command, ""))

    @unittest.skipIf(hasattr(os, "geteuid") and os.geteuid() == 0, "root may read everything")
    def test_unreadable_file_is_named(self):
        path = pathlib.Path(self.folder.name, "secret.nml")
        shutil.copy(BOX, path)
        path.chmod(0)
        for command in ("run", "check"):
            self.assertTrue(self.complaint(command, "secret.nml").startswith("secret.nml: cannot be read ("))

    def test_empty_file_lacks_everything(self):
        pathlib.Path(self.folder.name, "empty.nml").touch()
        for command in ("run", "check"):
            self.assertTrue(self.complaint(command, "empty.nml").startswith("empty.nml:1: the group &body is missing"))


def add_tests():
    """One test per file and command, and one per setting. All files are given to `check`, those whose turn it is also to `run`."""
    for number, path in enumerate(sorted(MALFORMED.glob("*.nml"))):
        for command in ("run", "check") if in_turn(number) else ("check",):

            def test(self, path=path, command=command):
                self.check_file(path, command)

            setattr(OneLine, f"test_{command}_{path.stem}", test)
    for name, (setting, fragment) in SETTINGS.items():

        def test_setting(self, setting=setting, fragment=fragment):
            self.check_setting(setting, fragment)

        setattr(OneLine, f"test_set_{name}", test_setting)


add_tests()

if __name__ == "__main__":
    unittest.main()

"""The examples of all docstrings."""

import doctest
import importlib
import os
import pkgutil
import unittest

import numpy as np

import nutate
from test_nutate import SCENES

# Modules whose examples need a package that may be absent.
NEEDS = {"attitudes": "scipy", "pictures": "matplotlib"}


class Examples(unittest.TestCase):
    def setUp(self):
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(os.path.dirname(os.path.normpath(SCENES)))

    def test_examples_print_what_they_show(self):
        # The module nutate.view is a program, whose import would hide the function.
        for name in sorted(module.name for module in pkgutil.iter_modules(nutate.__path__) if module.name != "view"):
            with self.subTest(module=name):
                if name in NEEDS:
                    try:
                        importlib.import_module(NEEDS[name])
                    except ImportError:
                        continue
                module = importlib.import_module(f"nutate.{name}")
                failed, _ = doctest.testmod(module, extraglobs={"nutate": nutate, "np": np},
                                            optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
                self.assertEqual(failed, 0)

    def test_public_functions_have_examples(self):
        for name in ("solve", "sweep", "run", "view", *(name for name in nutate.__all__ if "quat" in name)):
            self.assertIn(">>>", getattr(nutate, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()

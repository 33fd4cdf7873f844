"""The examples of all docstrings."""

import doctest
import importlib
import inspect
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

    def test_public_classes_have_examples(self):
        for name, public in self.public(inspect.isclass):
            if not issubclass(public, Exception):
                self.assertIn(">>>", public.__doc__, name)

    def test_arguments_and_results_are_described_in_numpydoc(self):
        for name, function in self.functions():
            described = inspect.getdoc(function) or ""
            signature = inspect.signature(function)
            arguments = [argument for argument in signature.parameters.values() if argument.name != "self"]
            with self.subTest(function=name):
                for argument in arguments:
                    stars = {argument.VAR_POSITIONAL: r"\*", argument.VAR_KEYWORD: r"\*\*"}.get(argument.kind, "")
                    self.assertRegex(described, rf"(?m)^(\w+, )*{stars}{argument.name}(, \w+)*( :.*)?$|those of `step`")
                if arguments and signature.return_annotation not in ("None", None):
                    self.assertRegex(described, r"Returns\n-+\n")

    def public(self, kind):
        """Public names of the package and what they are."""
        return [(name, getattr(nutate, name)) for name in nutate.__all__ if kind(getattr(nutate, name))]

    def functions(self):
        """Public functions, and methods of public classes that are written in Python, by their names."""
        yield from self.public(inspect.isfunction)
        for name, public in self.public(inspect.isclass):
            for method, function in inspect.getmembers(public, inspect.isfunction):
                if not method.startswith("_") and function.__module__.startswith("nutate"):
                    yield f"{name}.{method}", function


if __name__ == "__main__":
    unittest.main()

"""README, tutorials and how-to guides: what they show of the command line runs, and the README stays short.

tools/checks/check-docs.py runs all of their blocks, with an installed nutate."""
import os
import pathlib
import re
import unittest

from pages import ROOT, Runner, marked_pages, missing_line, pages
from support import PATIENCE, CommandLineTest


class Pages(CommandLineTest):
    def setUp(self):
        super().setUp()
        os.mkdir(self.path("bin"))
        os.symlink(os.path.realpath(self.program), self.path("bin/nutate"))
        environment = {**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]}
        self.runner = Runner(self.path("page"), environment, installed=False, patience=PATIENCE)

    def run_page(self, text):
        """What is wrong with a page of this text."""
        self.write("page.md", text)
        return self.runner.problems(pathlib.Path(self.path("page.md")))

    def test_commands_of_pages_do_what_they_show(self):
        for path in pages():
            with self.subTest(page=str(path.relative_to(ROOT))):
                self.assertEqual(self.runner.problems(path)[1], [])

    def test_marked_blocks_of_other_pages_run(self):
        for path in marked_pages():
            with self.subTest(page=str(path.relative_to(ROOT))):
                self.assertEqual(self.runner.problems(path, strict=False)[1], [])

    def test_mistakes_in_pages_are_found(self):
        for text, says in (("```console\n$ nutate chekc scenes/box.nml\n```\n", "ends with 2"),
                           ("```console\n$ nutate --version\nnutatte 0.1.0\n```\n", "does not print"),
                           ("<!-- exit status: 2 -->\n```console\n$ nutate --version\n```\n", "not 2"),
                           ("<!-- file: top.nml -->\n```nml\n&body densty = 3 /\n```\n", "densty"),
                           ("```nml\n&gravity /\n```\n", "without a comment")):
            with self.subTest(text=text):
                ran, wrong = self.run_page(text)
                self.assertEqual((ran, len(wrong)), (1, 1))
                self.assertIn(says, wrong[0])

    def test_lines_left_out_and_digits_left_out_do_not_matter(self):
        for printed in ("1.5e-3", "1.52e-3", "0.00149"):
            self.assertIsNone(missing_line(["a 1.5e-3 b", "...", "end"], f"a {printed} b\nmore\nend\n"), printed)
        for printed in ("-1.5e-3", "1.7e-3", "1.5e-2"):
            self.assertEqual(missing_line(["a 1.5e-3 b"], f"a {printed} b\n"), "a 1.5e-3 b", printed)
        self.assertEqual(missing_line(["3 rows"], "4 rows\n5 rows\n"), "3 rows")
        self.assertIsNone(missing_line(["5 rows"], "4 rows\n5 rows\n"))
        self.assertIsNone(missing_line(["wall time 0.1 s", "residual 2.1E-15"], "wall time 7 s\nresidual 4E-16\n"))
        self.assertEqual(missing_line(["end", "a 1 b"], "a 1 b\nend\n"), "a 1 b")
        self.assertEqual(missing_line(["omega1"], "omega2\n"), "omega1")
        self.assertEqual(missing_line(["the whole line"], "the whole\n"), "the whole line")


class Form(unittest.TestCase):
    def test_the_readme_is_short(self):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        self.assertLessEqual(text.count("\n"), 150)
        self.assertLessEqual(len(text.split()), 1100)

    def test_a_guide_solves_one_task(self):
        for path in (ROOT / "docs" / "how-to").glob("*.md"):
            with self.subTest(page=path.name):
                self.assertIn(len(path.read_text(encoding="utf-8").split()), range(300, 801))

    def test_tables_are_narrow(self):
        for path in (ROOT / "README.md", *(ROOT / "docs").glob("**/*.md")):
            for line in path.read_text(encoding="utf-8").splitlines():
                if line.startswith("|"):
                    with self.subTest(page=path.name, line=line):
                        self.assertLessEqual(len(line), 160)

    def test_every_page_is_in_a_table_of_contents(self):
        docs = ROOT / "docs"
        pages = set(docs.glob("**/*.md"))
        contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
        listed = {docs / "index.md"}
        for path in pages:
            text = path.read_text(encoding="utf-8")
            # Pages for developers are not in the sidebar.
            if text.startswith("---\norphan: true\n---\n") and f"({path.relative_to(ROOT)})" in contributing:
                listed.add(path)
            for block in re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
                for entry in block.split():
                    if not entry.startswith(":"):
                        listed.update(path.parent.glob(entry + ".md"))
        self.assertEqual(sorted(path.name for path in pages - listed), [])

    def test_what_pages_link_to_is_there(self):
        for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *pages()):
            for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", path.read_text(encoding="utf-8")):
                with self.subTest(page=path.name, link=link):
                    self.assertTrue((path.parent / link).exists())


if __name__ == "__main__":
    unittest.main()

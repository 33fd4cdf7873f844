"""The pages of results say how they are made, have a table in each part, and show the worst variant of each hard case."""
import csv
import os
import re
import sys
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
RESULTS = os.path.join(ROOT, "docs", "results")
sys.path.insert(0, os.path.join(ROOT, "tools", "docs"))
import hard_cases  # noqa: E402


def text_of(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


class Results(unittest.TestCase):
    def test_pages_name_a_target_of_make(self):
        targets = re.findall(r"^([a-z]+):", text_of(ROOT, "Makefile"), re.MULTILINE)
        for page in sorted(os.listdir(RESULTS)):
            if page.endswith(".md"):
                with self.subTest(page):
                    named = re.search(r"^Made by `make ([a-z]+)", text_of(RESULTS, page), re.MULTILINE)
                    self.assertIn(named[1], targets)

    def test_no_part_is_empty(self):
        for page in sorted(os.listdir(RESULTS)):
            if page.endswith(".md"):
                for name, part in re.findall(r"<!-- begin (\w+) -->\n(.*?)<!-- end \1 -->", text_of(RESULTS, page), re.DOTALL):
                    with self.subTest(page, part=name):
                        self.assertTrue(part.strip())

    def test_a_row_shows_the_worst_variant(self):
        rows = list(csv.DictReader(text_of(RESULTS, "hard-cases.csv").splitlines()))
        page = text_of(RESULTS, "hard-cases.md")
        for case in {row["case"] for row in rows}:
            self.assertIn(sum(row["case"] == case for row in rows), (2, 4, 6), case)
        for group in hard_cases.read_cases(os.path.join(RESULTS, "hard-cases.txt")):
            with self.subTest(group[1]):
                line = next(line for line in page.splitlines() if line.startswith(f"| {group[1]} |"))
                shown = float(line.split("|")[3])
                largest = max(float(row[key]) for row in rows if row["group"] == group[0] for key in ("energy", "momentum", "norm"))
                self.assertAlmostEqual(shown, largest, delta=0.05*shown)


if __name__ == "__main__":
    unittest.main()

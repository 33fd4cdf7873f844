"""docs/reference/ says what the program knows: groups, keys, choices and defaults, columns, options, statuses."""
import re
import sys
import unittest

from support import ROOT

sys.path.insert(0, str(ROOT / "tools" / "docs" / "site"))
import header_text  # noqa: E402

REFERENCE = ROOT / "docs" / "reference"
# Where the keys of the groups stand that are no effects.
PARTS = {"scene": "nutate_scene_labels", "body": "nutate_scene_body", "initial": "nutate_scene_initial",
         "integrator": "nutate_scene_integrator", "output": "nutate_scene_output", "event": "nutate_scene_events",
         "ensemble": "nutate_scene_ensemble", "vary": "nutate_scene_vary", "free": "nutate_scene_free", "measurement": "nutate_scene_measurement",
         "fit": "nutate_scene_fit", "chaos": "nutate_scene_chaos", "frame": "nutate_scene_frame"}
# What every effect has.
COMMON = ("name", "on")


def source(name):
    """The text of a module and of its procedures."""
    return "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "src").rglob(f"{name}*.f90"))
                   if path.stem in (name, f"{name}_procedures"))


def keys_in(text):
    """Name, required or not, default and choices of the keys in a piece of source."""
    result = {}
    for piece in text.split("key_t(name='")[1:]:
        name, rest = piece.split("\n")[0].split("'", 1)
        default, choices = re.search(r"default='([^']*)'", rest), re.search(r"choices='([^']*)'", rest)
        result[name] = ("required=.true." in rest, default[1] if default else "",
                        choices[1].split(",") if choices else [])
    return result


def known_groups():
    """The keys of every group that a scene can have, by its name."""
    groups = {group: keys_in(source(module)) for group, module in PARTS.items()}
    catalogue = source("nutate_effect_catalogue")
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "src" / "model" / "effects").rglob("*.f90")]
    for group, table in re.findall(r"call add_kind\('(\w+)', (\w+)", catalogue):
        found = next(re.search(rf":: {table}\(\d+\) = \[(.*?)\)\]", text, re.DOTALL) for text in sources
                     if re.search(rf":: {table}\(\d+\) =", text))
        groups[group] = keys_in(found[1] + ")")
    return groups


def documented_groups():
    """Rows (key, unit, default, meaning) of the tables of keys below the headings that name a group, and the page's text."""
    groups, texts = {}, {}
    for path in sorted((REFERENCE / "scenes").glob("*.md")):
        text, group = path.read_text(encoding="utf-8"), None
        for line in re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE).splitlines():
            if line.startswith("#"):
                named = re.search(r"`&(\w+)`", line)
                group = named[1] if named else group
                in_table = False
            elif line.startswith("| key |"):
                in_table = True
            elif not line.startswith("|"):
                in_table = False
            elif in_table and group and not line.startswith("|---"):
                cells = [cell.strip() for cell in line.strip("|").split(" |")]
                groups.setdefault(group, {})[cells[0].strip(" `")] = [cell.strip() for cell in cells[1:]]
                texts[group] = text
    return groups, texts


class Scenes(unittest.TestCase):
    known = known_groups()
    documented, texts = documented_groups()

    def test_every_group_and_key_is_documented_and_no_other(self):
        self.assertEqual(sorted(self.known), sorted(self.documented))
        for group, keys in self.known.items():
            with self.subTest(group=group):
                self.assertGreater(len(keys), 0)
                self.assertEqual(sorted(keys), sorted(self.documented[group]))

    def test_required_keys_and_defaults_are_those_of_the_program(self):
        for group, keys in self.known.items():
            for key, (required, default, _) in keys.items():
                with self.subTest(group=group, key=key):
                    shown = self.documented[group].get(key, ["", ""])[1].replace("`", "").strip("'")
                    if required:
                        self.assertEqual(shown, "required")
                    if default:
                        self.assertEqual(shown, default)

    def test_every_choice_is_named(self):
        for group, keys in self.known.items():
            for key, (_, _, choices) in keys.items():
                for choice in choices:
                    with self.subTest(group=group, key=key, choice=choice):
                        self.assertTrue(f"'{choice}'" in self.texts.get(group, ""))

    def test_what_every_effect_has_is_documented_once(self):
        common = re.findall(r"^\| `(\w+)` \|", (REFERENCE / "scenes" / "effects.md").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(tuple(common), COMMON)
        declared = re.search(r"\[keys, (.*)\]", source("nutate_effect_catalogue"))[1]
        self.assertEqual(tuple(keys_in(declared)), COMMON)


class Lists(unittest.TestCase):
    def page(self, name):
        return (REFERENCE / f"{name}.md").read_text(encoding="utf-8")

    def test_every_set_of_columns_is_documented(self):
        table = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src" / "io" / "quantities").glob("*.f90"))
        sets = re.findall(r"quantity_t\('([\w#]+)', '([^']*)'", table.replace("euler_#", "euler_321"))
        self.assertGreater(len(sets), 50)
        page = self.page("columns")
        for name, headers in sets:
            base, headers = name.replace("#", "1"), headers.replace("#", "1")
            with self.subTest(set=name):
                if re.fullmatch(r"euler_\d{3}", name):
                    self.assertTrue(f"`{name[-3:]}`" in page)
                    continue
                self.assertTrue(f"`{base}`" in page)
                for header in headers.split(","):
                    self.assertTrue(re.sub(r"\d$", "", header) in page, header)

    def test_every_command_and_option_is_documented(self):
        cli = (ROOT / "app" / "nutate_cli.f90").read_text(encoding="utf-8")
        page = self.page("command-line")
        for name in re.findall(r"verb_t\('(\w+)'", cli):
            self.assertTrue(f"`nutate {name} " in page, name)
        options = re.findall(r"option_t\('(--[\w-]+)'", cli)
        self.assertGreater(len(options), 10)
        for name in options:
            self.assertTrue(re.search(rf"`(nutate )?{name}[` ]", page), name)
        for name in re.findall(r"^\| `(--[\w-]+)", page, re.MULTILINE):
            self.assertIn(name, options)

    def test_every_status_is_documented(self):
        codes = re.findall(r"integer, parameter :: (NUTATE_\w+) = (\d+)", source("nutate_status"))
        page = self.page("errors")
        self.assertEqual([(name, code) for code, name in re.findall(r"^\| (\d+) \| `(NUTATE_\w+)`", page, re.MULTILINE)], codes)

    def test_every_name_of_the_python_package_is_documented(self):
        package = (ROOT / "python" / "nutate" / "__init__.py").read_text(encoding="utf-8")
        names = re.findall(r'"(\w+)"', package[package.index("__all__"):])
        self.assertGreater(len(names), 20)
        documented = re.findall(r"^(?:\.\. auto\w+:: |   (?=[A-Z]))(\w+)$", self.page("python"), re.MULTILINE)
        self.assertEqual(sorted(documented), sorted(name for name in names if not name.startswith("__")))

    def test_every_header_is_documented(self):
        shown = re.findall(r"^```\{c-header\} (\w+\.h)$", self.page("c"), re.MULTILINE)
        self.assertEqual(sorted(shown), sorted(path.name for path in (ROOT / "include").glob("*.h")))

    def test_every_function_of_the_headers_is_shown_once(self):
        for path in (ROOT / "include").glob("*.h"):
            text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
            declared = re.findall(r"^int (nutate_\w+)\(", text, re.MULTILINE)
            shown = re.findall(r"^`+\{c:function\} int (nutate_\w+)\(", header_text.markdown(path.name), re.MULTILINE)
            with self.subTest(header=path.name):
                self.assertEqual(shown, declared)

    def test_names_of_module_nutate_are_those_that_there_are(self):
        public = (ROOT / "src" / "nutate.f90").read_text(encoding="utf-8")
        tables = self.page("fortran").split("## Module `nutate`")[1].split("## Other modules")[0]
        for name in re.findall(r"`(\w+)`", "\n".join(line for line in tables.splitlines() if line.startswith("|"))):
            self.assertTrue(re.search(rf"\b{name}\b", public), name)


if __name__ == "__main__":
    unittest.main()

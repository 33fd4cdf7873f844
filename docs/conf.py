"""Sphinx builds the documentation from this file: `make docs`. No page loads anything from the network."""

import os
import pathlib
import re
import sys

from sphinx.util.inspect import TypeAliasForwardRef

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tools" / "docs" / "site")]

project = "nutate"
author = "the nutate developers"
copyright = re.search(r"Copyright \(c\) (.*)", (ROOT / "LICENSE").read_text(encoding="utf-8"))[1]
version = release = re.search(r'^version *= *"(.*)"', (ROOT / "fpm.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]

# The addresses of repository and site stand in one place.
ADDRESSES = dict(re.findall(r'^(repository-code|url): *"(.*?)"', (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE))

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon", "sphinx.ext.mathjax",
              "sphinx-mathjax-offline", "sphinx_design", "c_header", "scene_lexer", "unbroken"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_inline"]
myst_heading_anchors = 4
# The tutorial in Python runs while the pages are built.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
# Links to files of the project that are not pages become downloads.
exclude_patterns = ["public-api.txt"]

# A page for each class of the Python package, written while the pages are built.
templates_path = ["_templates"]
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_param = False
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
default_role = "code"
smartquotes = False
autodoc_type_aliases = {"npt.ArrayLike": "ArrayLike", "Array": "Array", "Textual": "Textual", "Rows": "Rows"}
# What the pages name and no page of this site describes.
nitpick_ignore_regex = [("py:.*", r"(np|npt|numpy|ctypes|collections|os|typing|plotly|pandas|xarray|pathlib|_ctypes)\..*"),
                        ("py:.*", r"(Any|Optional|Union|Sequence|Mapping|Iterable|Iterator|Callable|Array|Textual|SceneOrPath|Rows|ArrayLike|.*Callback)"),
                        ("py:class", r"(nutate\._.*|nutate\.\w+\._?[A-Z]\w*|_.*|optional|callable)"),
                        # Words of numpydoc types, such as `array, shape (n, 4)`.
                        ("py:class", r"(arrays?|shape|or|of|n|k|m|\d|complex|)"),
                        ("py:exc", r"(ImportError|KeyboardInterrupt|Exception)"),
                        ("c:identifier", r"(size_t|u?int64_t)")]

html_theme = "furo"
html_title = f"nutate {release}"
html_static_path = ["_static"]
html_css_files = ["nutate.css"]
html_show_sourcelink = False
html_copy_source = False
# Summaries would be fetched, which browsers refuse to pages opened as files.
html_show_search_summary = False
# The reference of the Fortran modules, which FORD writes.
html_extra_path = [os.environ[name] for name in ("NUTATE_FORD",) if name in os.environ]
pygments_style = "friendly"
pygments_dark_style = "monokai"


def fill_in_addresses(_app, _page, source):
    """Replaces the names of addresses in pages, as `@repository-code@`."""
    for name, address in ADDRESSES.items():
        source[0] = source[0].replace(f"@{name}@", address)


def setup(app):
    """Registers what is done to the text of pages, and shows aliases of types by their names."""
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name
    app.connect("source-read", fill_in_addresses)

"""Keeps a number together with its unit, and with its sign, at the end of a line of text; and sets dashes as such."""

import re

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

SPACE = "\N{NO-BREAK SPACE}"
# Units as the pages write them, after a number.
UNITS = "%|°/?s?|rad(?:/s²?)?|m?s|min|h|d|ns|µs|km?|mm?|kg|N|mN|A|T|nT|J|MB|GB|kB|KiB|MiB|bytes|steps|bodies|members"
BETWEEN = re.compile(rf"(?<=\d)\s(?=(?:{UNITS})(?![\w-]))|(?<=±)\s(?=\d)|(?<=\d)\s(?=±)|(?<=FORTRAN)\s(?=77)")


class Unbroken(SphinxPostTransform):
    """Replaces blanks between numbers and units by blanks at which no line ends, and the two hyphens of napoleon by a dash."""

    default_priority = 900

    def run(self, **kwargs):
        """Changes all text of a page except code and formulas."""
        kept = (nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.raw, nodes.comment)
        for text in list(self.document.findall(nodes.Text)):
            parent = text.parent
            while parent is not None and not isinstance(parent, kept):
                parent = parent.parent
            if parent is None and (changed := BETWEEN.sub(SPACE, text.astext()).replace(" -- ", " \N{EN DASH} ")) != text.astext():
                text.parent.replace(text, nodes.Text(changed))


def setup(app):
    """Registers the replacement."""
    app.add_post_transform(Unbroken)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Keeps a number together with its unit, and with its sign, at the end of a line of text; and sets dashes as such."""

import itertools
import re

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

SPACE = "\N{NO-BREAK SPACE}"
# Units as the pages write them, after a number.
UNITS = "%|°/?s?|rad(?:/s²?)?|m?s|min|h|d|ns|µs|km?|mm?|kg|N|mN|A|T|nT|J|MB|GB|kB|KiB|MiB|bytes|steps|bodies|members"
BETWEEN = re.compile(rf"(?<=\d)\s(?=(?:{UNITS})(?![\w-]))|(?<=±)\s(?=\d)|(?<=\d)\s(?=±)|(?<=FORTRAN)\s(?=77)"
                     r"|(?<=\d)\s(?=\d{3}(?!\d))|(?<= =)\s(?=[-−]?\d)")


class Unbroken(SphinxPostTransform):
    """Replaces blanks between numbers and units by blanks at which no line ends, and the two hyphens of napoleon by a dash."""

    default_priority = 900

    def run(self, **kwargs):
        """Changes all text of a page except code and formulas."""
        kept = (nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.raw, nodes.comment)
        for element in list(self.document.findall(nodes.TextElement)):
            above = element
            while above is not None and not isinstance(above, kept):
                above = above.parent
            if above is None:
                element.children = list(joined(element.children))
                for child in element.children:
                    element.setup_child(child)


def joined(children):
    """The children of an element; texts side by side, as the ends of lines are, become one."""
    for is_text, group in itertools.groupby(children, key=lambda child: isinstance(child, nodes.Text)):
        if is_text:
            yield nodes.Text(BETWEEN.sub(SPACE, "".join(group)).replace(" -- ", " \N{EN DASH} "))
        else:
            yield from group


def setup(app):
    """Registers the replacement."""
    app.add_post_transform(Unbroken)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

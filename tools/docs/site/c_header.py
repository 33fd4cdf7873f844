"""The directive `c-header`: every declaration of a header of include/ with its comment.

    ```{c-header} nutate_stepper.h
    ```
"""

import header_text
from sphinx.util.docutils import SphinxDirective


class CHeader(SphinxDirective):
    """Shows a header."""

    required_arguments = 1

    def run(self):
        """Returns the nodes of the header."""
        path = header_text.INCLUDE / self.arguments[0]
        self.env.note_dependency(str(path))
        return self.parse_text_to_nodes(header_text.markdown(self.arguments[0]), allow_section_headings=True)


def setup(app):
    """Registers the directive."""
    app.add_directive("c-header", CHeader)
    return {"parallel_read_safe": True}

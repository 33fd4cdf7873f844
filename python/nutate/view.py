"""`python3 -m nutate.view SCENE`: runs a scene and writes a web page that shows it; `nutate view SCENE` does this.

In a program, nutate.view(result) gives the page."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Optional, Sequence

from ._library import NutateError, NutateOSError
from ._page import view


class Change(argparse.Action):
    """--set and --unset, in the order in which they stand."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: object,
                 option_string: Optional[str] = None) -> None:
        namespace.changes = [*namespace.changes, f"-{values}" if option_string == "--unset" else str(values)]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Exit status: 0 success; 2 the scene is wrong; 3 the run failed half-way; 4 the page cannot be written."""
    parser = argparse.ArgumentParser(prog="python3 -m nutate.view", description="Runs a scene and writes a web page that shows it.")
    parser.add_argument("scene", help="scene file")
    parser.add_argument("--output", metavar="FILE", help="output page, or - for standard output (default: NAME.html for NAME.nml)")
    parser.add_argument("--set", metavar="GROUP.KEY=VALUE", action=Change, help="override a value of the scene")
    parser.add_argument("--unset", metavar="GROUP.KEY", action=Change, help="remove a key from the scene")
    parser.add_argument("--from", metavar="T", type=float, dest="start", help="first time that is animated, s (default: the start)")
    parser.set_defaults(changes=[])
    options = parser.parse_args(arguments)
    output = options.output or os.path.splitext(os.path.basename(options.scene))[0] + ".html"
    try:
        page = view(options.scene, None, *options.changes, start=options.start)
    except NutateOSError as error:
        return complain(naming_options(str(error)), 2)
    except NutateError as error:
        return complain(naming_options(str(error)), 2 if isinstance(error, ValueError) else 3)
    try:
        if output == "-":
            output = "standard output"
            with open(1, "wb", closefd=False) as stream:
                stream.write(page.text.encode("utf-8", "replace"))
        else:
            page.save(output)
    except BrokenPipeError:
        return 4
    except OSError as error:
        return complain(f"nutate: cannot write {output}: {error.strerror}", 4)
    return 0


def naming_options(message: str) -> str:
    """Names the options of the program instead of the overrides that they make."""
    for place, option in (("override: ", "--set: "), ("override with '-': ", "--unset: ")):
        if message.startswith(place):
            return option + message[len(place):]
    return message


def complain(line: str, status: int) -> int:
    """Prints an error; returns the exit status."""
    print(line, file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())

"""The ``nmap`` command (also installed as ``nmaptool``)."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence

from cyclopts import App, Parameter

from nmaptool._version import __version__
from nmaptool_cli.session import guarded

HELP = """Normal maps in, carved bas-reliefs in exact millimetres out.

Start with: nmap inspect MAP, then nmap relief MAP -o relief.stl --preview relief.png
"""

app = App(
    name="nmap",
    help=HELP,
    help_format="markdown",
    version=__version__,
    version_flags=["--version"],
    result_action="return_value",
    default_parameter=Parameter(negative="", allow_leading_hyphen=False),
)
# commands load when they are called, so that --help stays quick
app.command(
    "nmaptool_cli.inspect:inspect", name="inspect", help="Look a normal map over and say what is wrong with it."
)
app.command(
    "nmaptool_cli.relief:relief", name="relief", help="Make a relief in millimetres from one or two normal maps."
)


_SIGNED_VALUE = re.compile(r"-[\d.rgb]")


def _join_signed(arguments: list[str]) -> list[str]:
    """``--swizzle -g,r,b`` as ``--swizzle=-g,r,b``, and lengths likewise: their values may start with a minus sign."""
    joined: list[str] = []
    for word in arguments:
        if joined and joined[-1] in ("--swizzle", "--height", "--width") and _SIGNED_VALUE.match(word):
            joined[-1] = f"{joined[-1]}={word}"
        else:
            joined.append(word)
    return joined


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    code: int = guarded(app, _join_signed(list(sys.argv[1:] if arguments is None else arguments)))
    return code


def run() -> None:
    """Entry point of the console scripts."""
    sys.exit(main())

"""The ``nmap`` command (also installed as ``nmaptool``)."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from types import FunctionType
from typing import Any

from cyclopts import App, Parameter

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool_cli.compose import HELP as COMPOSE_HELP
from nmaptool_cli.interrupt import interruptible
from nmaptool_cli.session import STREAM, run_guarded

HELP = """Meshes and normal maps in, carved bas-reliefs in exact millimetres out.

From a mesh: nmap bake MESH -o maps, then nmap relief maps/original.exr --detail maps/detail.exr -o relief.stl

From a map: nmap inspect MAP, then nmap relief MAP -o relief.stl --preview relief.png
"""

app = App(
    name="nmap",
    help=HELP,
    help_format="markdown",
    version=__version__,
    version_flags=["--version"],
    result_action="return_value",
    default_parameter=Parameter(negative=""),
    suppress_keyboard_interrupt=False,
)
# commands load when they are called, so that --help stays quick
app.command(
    "nmaptool_cli.inspect:inspect", name="inspect", help="Look a normal map over and say what is wrong with it."
)
app.command("nmaptool_cli.bake:bake", name="bake", help="Draw a mesh as original, base and detail normal maps.")
app.command("nmaptool_cli.compare:compare", name="compare", help="Compare gSfG with Poisson reconstruction on a mesh.")
app.command("nmaptool_cli.compose:app", name="compose", help=COMPOSE_HELP)
app.command(
    "nmaptool_cli.relief:relief", name="relief", help="Make a relief in millimetres from one or two normal maps."
)
app.command(
    "nmaptool_cli.smooth:smooth", name="smooth", help="Rebuild a mesh without its fine detail, or with more of it."
)
app.command("nmaptool_cli.train:train", name="train", help="Learn a filter from meshes of your own.")


# flags whose values may start with a minus sign
_SIGNED = (
    *("--swizzle", "--height", "--width", "--target", "--azimuth", "--elevation", "--roll"),
    *("--size", "--margin", "--pitch", "--sigma-s"),
    *("--at", "--rotate", "--feather", "--scale", "--strength", "--height-factor"),
    *("--crop", "--pad", "--affine", "--resize", "--depth-scale", "--jump", "--smooth", "--fov"),
    *("--detail-gain", "--closeness"),
)
# flags that take whole numbers: the parser would round
_WHOLE = ("--max-iterations", "--iterations", "--max-faces", "--steps")
_DASH_VALUE = re.compile(r"--?[a-z][a-z-]*=-")
_SIGNED_VALUE = re.compile(r"-[\d.rgb]")


def _plain_words(arguments: list[str]) -> list[str]:
    """The arguments as the parser can take them.

    ``--swizzle -g,r,b`` becomes ``--swizzle=-g,r,b``, and lengths likewise, since their values may start with a minus
    sign; ``-`` becomes the name that `nmaptool_cli.session` knows standard input and output by.
    """
    joined: list[str] = []
    for word in arguments:
        if joined and joined[-1] in _WHOLE and not word.isdecimal() and not word.startswith("-"):
            raise UsageError(f"{joined[-1]} {word!r}: must be a whole number")
        if word == "-":
            joined.append(STREAM)
        elif _DASH_VALUE.fullmatch(word):
            joined.append(word[:-1] + STREAM)
        elif joined and joined[-1] in _SIGNED and _SIGNED_VALUE.match(word):
            joined[-1] = f"{joined[-1]}={word}"
        else:
            joined.append(word)
    return joined


def _call(words: list[str]) -> Any:
    """Run a command; its own --help shows its docstring with the example, lists of commands its one line."""
    named = [each for each in app.parse_commands(words)[1] if isinstance(each.default_command, FunctionType)]
    lines = [command.help for command in named]
    for command in named:
        command.help = command.default_command.__doc__
    try:
        return app(words, exit_on_error=False, print_error=False)
    finally:
        for command, line in zip(named, lines, strict=True):
            command.help = line


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    code: int = run_guarded(lambda: _call(_plain_words(words)))
    return code


def run() -> None:
    """Run the command of this process and end it."""
    # the solver's dot products are short: threads of the linear algebra library cost more than they bring
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with interruptible():
        code = main()
    sys.exit(code)

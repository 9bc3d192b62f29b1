"""The ``nmap`` command (also installed as ``nmaptool``)."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from typing import Any

from cyclopts import App, Parameter

from nmaptool._version import __version__
from nmaptool.core.extension import kernels_in_use
from nmaptool_cli.arguments import prepared
from nmaptool_cli.command import Command, command_of
from nmaptool_cli.compose import HELP as COMPOSE_HELP
from nmaptool_cli.guard import run_guarded
from nmaptool_cli.interrupt import interruptible

HELP = """Turn meshes and normal maps into bas-reliefs with exact sizes in millimetres.

From a mesh: nmap bake MESH -o maps, then nmap relief maps/original.exr --detail maps/detail.exr -o relief.stl

From a map: nmap inspect MAP, then nmap relief MAP -o relief.stl --preview relief.png
"""


def _version() -> str:
    """The version, and what runs the inner loops."""
    return f"{__version__} ({kernels_in_use()} kernels)"


app = App(
    name="nmap",
    help=HELP,
    help_format="markdown",
    version=_version,
    version_flags=["--version"],
    result_action="return_value",
    default_parameter=Parameter(negative=""),
    suppress_keyboard_interrupt=False,
)
# commands are imported when they are called, so that --help stays quick
for _name, _help in (
    ("inspect", "Inspect a normal map and report what is wrong with it."),
    ("bake", "Render a mesh to original, base and detail normal maps."),
    ("compare", "Compare gSfG with Poisson reconstruction on a mesh."),
    ("relief", "Make a relief in millimetres from one or two normal maps."),
    ("preview", "Show reliefs in a material, without OpenGL: pictures, sections and films."),
    ("batch", "Run a command for many files, several at a time."),
    ("studio", "Shape a relief in the browser, under a light that you move."),
    ("smooth", "Remove the fine detail of a mesh, or exaggerate it."),
    ("train", "Train a filter on your own meshes."),
):
    app.command(f"nmaptool_cli.{_name}:{_name}", name=_name, help=_help)
app.command("nmaptool_cli.compose:app", name="compose", help=COMPOSE_HELP)
app.command(
    "nmaptool_cli.completion:install_completion",
    name="--install-completion",
    help="Complete commands and flags with Tab, in bash, zsh or fish.",
)


def _call(words: list[str]) -> Any:
    """Run a command. Its own --help shows its full docstring with the example; lists of commands show one line."""
    named = [each for each in app.parse_commands(words)[1] if hasattr(each.default_command, "command")]
    commands: list[Command] = [command_of(each.default_command) for each in named]
    lines = [each.help for each in named]
    for each in named:
        each.help = each.default_command.__doc__
    try:
        return app(prepared(words, commands[-1] if commands else None), exit_on_error=False, print_error=False)
    finally:
        for each, line in zip(named, lines, strict=True):
            each.help = line


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    code: int = run_guarded(lambda: _call(words))
    return code


def run() -> None:
    """Run the command line of this process and exit."""
    # the solver's dot products are short: threads of the linear algebra library cost more time than they save
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if isinstance(sys.stdout, io.TextIOWrapper):  # the code page of a pipe on Windows lacks most letters
        sys.stdout.reconfigure(errors="backslashreplace")
    with interruptible():
        code = main()
    sys.exit(code)

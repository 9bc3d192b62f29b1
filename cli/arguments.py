"""Command-line arguments, prepared for the parser."""

from __future__ import annotations

import re

from nmaptool.core.errors import UsageError
from nmaptool_cli.command import Command
from nmaptool_cli.streams import STREAM

_DASH_VALUE = re.compile(r"--?[a-z][a-z-]*=-")
_SIGNED_VALUE = re.compile(r"-[\d.rgb]")


def prepared(arguments: list[str], command: Command | None) -> list[str]:
    """The arguments with ``--swizzle -g,r,b`` as one word and ``-`` as the name of standard input.

    Parameters
    ----------
    arguments : list of str
    command : Command or None
        Knows which flags take text that may begin with a minus sign, and which take whole numbers (the parser would
        round them).

    Raises
    ------
    UsageError
        If the value of a whole-number flag is not a whole number.
    """
    signed, whole = (command.signed, command.whole) if command is not None else (frozenset(), frozenset())
    joined: list[str] = []
    for word in arguments:
        if joined and joined[-1] in whole and not word.isdecimal() and not word.startswith("-"):
            raise UsageError(f"{joined[-1]} {word!r}: must be a whole number")
        if word == "-":
            joined.append(STREAM)
        elif _DASH_VALUE.fullmatch(word):
            joined.append(word[:-1] + STREAM)
        elif joined and joined[-1] in signed and _SIGNED_VALUE.match(word):
            joined[-1] = f"{joined[-1]}={word}"
        else:
            joined.append(word)
    return joined

"""Options as flags of the command line: ``--sigma-s 2%`` for ``sigma_s='2%'``."""

from __future__ import annotations

import shlex
from typing import Any

from nmaptool.core.mentions import rendered, written_name


def flag_of(name: str) -> str:
    """The flag of a field: ``--sigma-s`` of ``sigma_s``, ``--from`` of ``from_``."""
    return "--" + written_name(name).replace("_", "-")


def in_flags(text: str) -> str:
    """A message of the library with its options as flags.

    >>> in_flags("`fit='scale'` needs `height`; for an engraving use `delta=-30`")
    '--fit scale needs --height; for an engraving use --delta=-30'
    """
    return rendered(text, _words)


def _words(name: str, value: Any) -> str:
    """A flag and its value in shell syntax; a value that begins with a minus sign needs =."""
    if value is None or value is True:
        return flag_of(name)
    word = shlex.quote(f"{value:g}" if isinstance(value, float) else str(value))
    return f"{flag_of(name)}{'=' if word.startswith('-') else ' '}{word}"

"""Names of files with patterns and placeholders."""

from __future__ import annotations

import glob
import re
from collections.abc import Sequence
from pathlib import Path

from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.sets.identity import is_input

PLACEHOLDERS = ("stem", "name", "parent", "number")
# commands fill these themselves, for the parts of a relief
_LEFT = ("{row}", "{col}")
_BRACED = re.compile(r"\{\{|\}\}|\{([^{}]*)\}")
_NUMBER = re.compile(r"number:0?(\d{1,2})")


def expand(patterns: Sequence[str], folder: Path) -> list[str]:
    """Return the files of names and patterns, in the order of the patterns, each pattern's sorted by name.

    A file that several patterns name comes once. A name without ``*``, ``?`` and ``[`` stays, whether or not there is
    such a file; so does the name of an existing file that contains them.

    Parameters
    ----------
    patterns : sequence of str
        ``**`` stands for any folders. ``maps/*.exr:detail`` names a layer of each file.
    folder : Path
        What relative names are relative to.

    Raises
    ------
    InputError
        If no file fits a pattern.
    """
    found: dict[str, None] = {}
    for pattern in patterns:
        file, layer = _split(pattern)
        if not glob.has_magic(file) or (folder / file).exists():
            found.setdefault(pattern)
            continue
        fitting = glob.glob(file, root_dir=folder, recursive=True)  # noqa: PTH207 - names as they are given
        names = sorted(name for name in fitting if is_input(folder / name))
        if not names:
            raise InputError(f"{pattern}: no file fits this pattern")
        found.update(dict.fromkeys(name + layer for name in names))
    return list(found)


def _split(pattern: str) -> tuple[str, str]:
    """Return a pattern of files, and the layer with its colon, as in ``maps/*.exr:detail``."""
    file, mark, layer = pattern.rpartition(":")
    is_layer = bool(mark and layer and Path(file).suffix) and not {"/", "\\"} & set(layer)
    return (file, mark + layer) if is_layer else (pattern, "")


def has_placeholder(text: str) -> bool:
    """Whether a text has a placeholder, known or not, or a doubled brace.

    >>> has_placeholder("out/{stem}.stl"), has_placeholder("out/lion.stl")
    (True, False)
    """
    return _BRACED.search(text) is not None


def fill(text: str, source: str, number: int) -> str:
    """Replace the placeholders of a text.

    Parameters
    ----------
    text : str
        ``{{`` and ``}}`` stand for braces.
    source : str
        The input: ``{name}`` is its file name, ``{stem}`` that without its extension, ``{parent}`` the folder that it
        lies in.
    number : int
        The place of the item in its job, from 1, for ``{number}``, or ``{number:03}`` with leading zeros.

    Raises
    ------
    UsageError
        If a placeholder is unknown.

    Examples
    --------
    >>> fill("out/{parent}-{stem}-{number:03}.stl", "maps/lions/a.b.png", 7)
    'out/lions-a.b-007.stl'
    """
    path = Path(_split(source)[0])
    values = {"stem": path.stem, "name": path.name, "parent": path.parent.name or ".", "number": str(number)}

    def value(found: re.Match[str]) -> str:
        if found[1] is None:
            return found[0][0]
        if found[0] in _LEFT:
            return found[0]
        padded = _NUMBER.fullmatch(found[1])
        if padded is not None:
            return f"{number:0{padded[1]}}"
        if found[1] not in values:
            known = ", ".join(f"{{{name}}}" for name in PLACEHOLDERS)
            raise UsageError(f"{text}: the placeholder {found[0]} is unknown; use {known}, or {{{{ for a brace")
        return values[found[1]]

    return _BRACED.sub(value, text)

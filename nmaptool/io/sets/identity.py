"""What identifies the files that an item reads."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

# files that name other files: they are read to find these
STORE_ENDING = ".zarr"
_MOST_BYTES = 16_000_000
_READERS = {".toml": tomllib.loads, ".gltf": json.loads}


def files_of(words: Iterable[str], folder: Path) -> list[Path]:
    """Return the existing files among words, and those that recipes and glTF files among them name, each once.

    Parameters
    ----------
    words : iterable of str
        Names, such as ``map.exr:detail``; any other word is ignored.
    folder : Path
        What relative names are relative to.
    """
    found: dict[Path, None] = {}
    waiting = [_file(word, folder) for word in words]
    while waiting:
        path = waiting.pop(0)
        if path is None or path in found:
            continue
        found[path] = None
        waiting += [_file(text, path.parent) for text in _strings(_contents(path))]
    return list(found)


def identity(path: Path) -> tuple[str, int, int]:
    """Return the name of a file or store with its size in bytes and the time of its last change in ns.

    Both are -1 if it is missing. It is not a hash of the contents: a set may hold terabytes, and every run of the batch
    would read all of them.
    """
    try:
        inner = [each.stat() for each in path.rglob("*") if each.is_file()] if path.is_dir() else []
        states = inner or [path.stat()]
    except OSError:
        return str(path), -1, -1
    return str(path), sum(each.st_size for each in states), max(each.st_mtime_ns for each in states)


def is_input(path: Path) -> bool:
    """Whether a path is a file, or a store, which is a folder."""
    return path.is_file() or (path.suffix == STORE_ENDING and path.is_dir())


def _file(word: str, folder: Path) -> Path | None:
    """Return the file that a word names; None if there is none."""
    from nmaptool.io.pictures.normal_maps import split_layer

    for name in dict.fromkeys((word, str(split_layer(word)[0]))):
        try:
            path = folder / name
            if name and is_input(path):
                return path
        except (OSError, ValueError):  # too long, or not a name
            continue
    return None


def _contents(path: Path) -> Any:
    """Return the values of a file that names others; None for any other file, or if it cannot be read."""
    read = _READERS.get(path.suffix.lower())
    if read is None or path.stat().st_size > _MOST_BYTES:
        return None
    try:
        return read(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):  # the command says what is wrong with it
        return None


def _strings(value: Any) -> Iterator[str]:
    """Return the texts of nested lists and tables."""
    waiting = [value]
    while waiting:
        each = waiting.pop()
        if isinstance(each, str):
            yield each
        elif isinstance(each, dict):
            waiting += each.values()
        elif isinstance(each, list):
            waiting += each

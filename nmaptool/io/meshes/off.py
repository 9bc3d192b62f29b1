"""Read OFF as text: positions and polygons; normals and colours are ignored."""

from __future__ import annotations

import re

import numpy as np

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.surface import Surface, TextPolygons
from nmaptool.io.meshes.words import Words, blocks, line_feeds, numbers, runs
from nmaptool.types.shown import counted

_HEADER = re.compile(rb"\s*(?:(?:ST)?C?N?(4?n?)OFF\b)?[ \t]*(BINARY\b)?")
_COUNTS = re.compile(rb"\s*(\d{1,18})[ \t]+(\d{1,18})(?:[ \t]+\d+)?[ \t]*(?:\n|\Z)")


def read_off(file: MeshFile, max_faces: int) -> Surface:
    """Read an OFF.

    Raises
    ------
    InputError
        If lines or numbers are missing or surplus, or a face refers to a vertex that does not exist.
    LimitError
        If it declares or holds more than ``max_faces``.
    """
    if b"\n" in file.head:
        claim = _without_comments(file.head[: file.head.rfind(b"\n") + 1])
        file.check_limit(_counts(file, claim)[1], max_faces)
    text = _without_comments(file.read_bytes())
    vertices, faces, start = _counts(file, text)
    pieces, done = [], 0
    for block in blocks(text[start:]):
        words = Words.of(block)
        split = max(vertices - done, 0)  # number of vertex lines in this block
        pieces.append(TextPolygons(*_vertices(words, split), *_polygons(words, split)))
        done += len(words.first)
    if done != vertices + faces:
        raise InputError(
            f"{file.path}: declares {counted(vertices, 'vertex')} and {counted(faces, 'face')} but holds "
            f"{counted(done, 'line')} of them: the OFF file is truncated or damaged; export it again"
        )
    return TextPolygons.joined(pieces).surface(file, 0, max_faces)


def _counts(file: MeshFile, text: bytes) -> tuple[int, int, int]:
    """The numbers of vertices and faces in the header, and the offset of the data after it."""
    header = _HEADER.match(text)
    if header is None:
        raise file.damaged
    if header[1]:
        raise InputError(f"{file.path}: holds OFF data of other than three dimensions; export it as OBJ, PLY or STL")
    if header[2]:
        raise InputError(f"{file.path}: holds binary OFF data; export it as text, or as PLY")
    counts = _COUNTS.match(text, header.end())
    if counts is None:
        raise file.damaged
    return int(counts[1]), int(counts[2]), counts.end()


def _without_comments(data: bytes) -> bytes:
    """The text without comments, with line feeds as line ends."""
    text = line_feeds(data)
    return re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text


def _vertices(words: Words, lines: int) -> tuple[bytes, int]:
    """The first three words of each of the first ``lines`` lines, and the number of these lines."""
    first = words.first[:lines]
    if (words.count[:lines] < 3).any():
        raise ValueError
    text = words.cut(words.begin[first], words.end[first + 2])
    if b"(" in text:  # nan(...), which C's number parser would accept
        raise ValueError
    return text, len(first)


def _polygons(words: Words, skip: int) -> tuple[Integers, Integers]:
    """Sizes and corners of the polygons after the first ``skip`` lines; colours after them are ignored."""
    first, count = words.first[skip:], words.count[skip:]
    begin = words.begin[first]
    digit = words.data[begin] - ord("0") <= 9
    sizes = numbers(words.cut(begin, words.end[first]), np.int64, len(first))
    if not digit.all() or (count <= sizes).any():
        raise ValueError
    chosen = runs(first + 1, sizes)
    return sizes, numbers(words.cut(words.begin[chosen], words.end[chosen]), np.int64, len(chosen))

"""Read STL, text and binary: the corners of its triangles; normals, names and colours are ignored."""

from __future__ import annotations

import re

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import STL_HEADER, MeshFile
from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.words import Words, blocks, line_feeds, numbers

_FACE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_NAME = re.compile(rb"solid\b[^\n]*")


def read_stl(file: MeshFile, max_faces: int) -> Surface:
    """Read an STL; each triangle gets its own three vertices.

    Raises
    ------
    InputError
        If it is truncated, or a face does not have three corners.
    LimitError
        If it declares or holds more than ``max_faces``.
    """
    if file.is_text and file.head.lstrip()[:5].lower() == b"solid":
        vertices, notes = _text(file, max_faces)
    else:
        notes = ()
        claimed = file.check_stl_claim(max_faces)
        table = np.frombuffer(file.read_bytes(), _FACE, claimed, STL_HEADER)
        vertices = table["corners"].astype(np.float64).reshape(-1, 3)
    return Surface(vertices, np.arange(len(vertices)).reshape(-1, 3), notes=notes)


def _text(file: MeshFile, max_faces: int) -> tuple[Float64, tuple[str, ...]]:
    """The (3 M, 3) float64 corners of a text STL, and what is said about it."""
    text, is_ended = _without_names(line_feeds(file.read_bytes()).lower())
    pieces, facets, ends, corners = [], 0, 0, 0
    for block in blocks(text, b"endfacet"):
        words = Words.of(block)
        vertices = np.flatnonzero(_is(words, b"vertex"))
        facets += int(_is(words, b"facet").sum())
        ends += int(_is(words, b"endfacet").sum())
        corners += len(vertices)
        pieces.append(_coordinates(words, vertices))
    if not is_ended and not (facets and text.rstrip().endswith(b"endfacet")):
        raise InputError(f"{file.path}: the STL file is truncated: its end is missing; export or download it again")
    if not facets == ends == corners / 3:
        raise file.damaged
    lacks_end = "its last line, 'endsolid', is missing: faces may be lost; export or download it again if so"
    file.check_limit(facets, max_faces)
    points = numbers(b" ".join(pieces), np.float64, 3 * corners).reshape(-1, 3)
    return points, () if is_ended else (lacks_end,)


def _without_names(text: bytes) -> tuple[bytes, bool]:
    """The text without its lines ``solid NAME`` and ``endsolid NAME``, and whether it ends with the latter.

    A name may contain any words.
    """
    pieces, done, is_ended = [], 0, False
    for match in _NAME.finditer(text):
        line = text.rfind(b"\n", 0, match.start()) + 1
        before = text[line : match.start()].lstrip(b" \t")
        if before in (b"", b"end"):
            pieces.append(text[done:line])
            done, is_ended = match.end(), before == b"end"
    return b"".join((*pieces, text[done:])), is_ended


def _coordinates(words: Words, vertices: Integers) -> bytes:
    """The three words after each of the words ``vertices``."""
    if (np.diff(vertices, append=len(words.begin)) <= 3).any():
        raise ValueError
    return words.cut(words.begin[vertices + 1], words.end[vertices + 3])


def _is(words: Words, word: bytes) -> Mask:
    """(W,) bool: which words equal ``word``."""
    same = np.asarray(words.end - words.begin == len(word))
    likely = words.begin[same]
    same[same] = (words.data[likely[:, None] + np.arange(len(word))] == np.frombuffer(word, np.uint8)).all(axis=1)
    return same

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
        vertices = _text(file, max_faces)
    else:
        claimed = file.check_stl_claim(max_faces)
        table = np.frombuffer(file.path.read_bytes(), _FACE, claimed, STL_HEADER)
        vertices = table["corners"].astype(np.float64).reshape(-1, 3)
    return Surface(vertices, np.arange(len(vertices)).reshape(-1, 3))


def _text(file: MeshFile, max_faces: int) -> Float64:
    """The (3 M, 3) float64 corners of a text STL."""
    text = _without_names(file, line_feeds(file.path.read_bytes()).lower())
    pieces, facets, ends, corners = [], 0, 0, 0
    for block in blocks(text, b"endfacet"):
        words = Words.of(block)
        vertices = np.flatnonzero(_is(words, b"vertex"))
        facets += int(_is(words, b"facet").sum())
        ends += int(_is(words, b"endfacet").sum())
        corners += len(vertices)
        pieces.append(_coordinates(words, vertices))
    if not facets == ends == corners / 3:
        raise file.damaged
    file.check_limit(facets, max_faces)
    return numbers(b" ".join(pieces), np.float64, 3 * corners).reshape(-1, 3)


def _without_names(file: MeshFile, text: bytes) -> bytes:
    """The text without its lines ``solid NAME`` and ``endsolid NAME``; a name may contain any words."""
    pieces, done, is_ended = [], 0, False
    for match in _NAME.finditer(text):
        line = text.rfind(b"\n", 0, match.start()) + 1
        before = text[line : match.start()].lstrip(b" \t")
        if before in (b"", b"end"):
            pieces.append(text[done:line])
            done, is_ended = match.end(), is_ended or before == b"end"
    if not is_ended:
        raise InputError(f"{file.path}: the STL file is truncated: its end is missing; export or download it again")
    return b"".join((*pieces, text[done:]))


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

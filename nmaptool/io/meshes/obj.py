"""Read OBJ: positions and polygons; everything else in the file is ignored, and no file that it names is opened."""

from __future__ import annotations

import re

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.surface import Surface, TextPolygons
from nmaptool.io.meshes.words import Words, blocks, line_feeds, numbers

CONTINUED = re.compile(rb"\\[ \t]*\n")  # a line that goes on in the next one


def read_obj(file: MeshFile, max_faces: int) -> Surface:
    """Read an OBJ.

    Raises
    ------
    InputError
        If a line is incomplete, or a face refers to a vertex that does not exist.
    LimitError
        If it holds more than ``max_faces`` triangles.
    """
    file.check_obj_count(max_faces)
    text = line_feeds(file.read_bytes())
    if b"\\" in text:
        text = CONTINUED.sub(b" ", text)
    pieces, seen = [], 0
    for block in blocks(text):
        words = Words.of(block)
        is_vertex = words.starts_with(b"v")
        pieces.append(TextPolygons(*_vertices(file, words, is_vertex), *_polygons(file, words, is_vertex, seen)))
        seen += pieces[-1].vertices
    polygons = TextPolygons.joined(pieces)
    last = text[text.rfind(b"\n") + 1 :]
    # a file truncated within a face
    if len(polygons.sizes) and polygons.sizes[-1] < 3 and last.lstrip().startswith(b"f"):
        raise file.damaged
    return polygons.surface(file, 1, max_faces)


def _vertices(file: MeshFile, words: Words, is_vertex: Mask) -> tuple[bytes, int]:
    """The first three words after each ``v``, and the number of such lines; weights and colours may follow."""
    if (words.count[is_vertex] < 4).any():
        raise file.damaged
    first = words.first[is_vertex]
    text = words.cut(words.end[first], words.end[first + 3])
    if b"\f" in text or b"\v" in text:  # only spaces and tabs may separate coordinates
        raise file.damaged
    return text, len(first)


def _polygons(file: MeshFile, words: Words, is_vertex: Mask, seen: int) -> tuple[Integers, Integers]:
    """Sizes and corners of the polygons, counted from 1; ``seen`` is the number of vertices in earlier blocks."""
    is_face = words.starts_with(b"f")
    chosen, sizes = words.of_lines(is_face, 1)
    begin, end = words.begin[chosen], words.end[chosen]
    line = np.repeat(np.arange(len(sizes)), sizes)
    # only the 7 of 7/5/3 is needed; a comment may follow on the line
    stop = np.minimum(words.until(b"/", begin), words.until(b"#", words.begin[words.first[is_face]])[line])
    kept = stop > begin
    line, begin, end = line[kept], begin[kept], np.minimum(end, stop)[kept]
    corners = numbers(words.cut(begin, end), np.int64, len(begin))
    if (corners < 0).any():
        corners = _absolute(file, corners, seen + np.cumsum(is_vertex)[is_face][line])
    if not corners.all():
        raise InputError(f"{file.path}: a face refers to vertex 0, but OBJ files count from 1; export it again")
    return np.bincount(line, minlength=len(sizes)), corners


def _absolute(file: MeshFile, corners: Integers, seen: Integers) -> Integers:
    """Corners counted from the first vertex; negative ones count back from the last vertex before their line."""
    beyond = np.flatnonzero(corners < -seen)
    if len(beyond):
        raise file.names_missing_vertex(int(corners[beyond[0]]), int(seen[beyond[0]]))
    return np.where(corners < 0, corners + seen + 1, corners)

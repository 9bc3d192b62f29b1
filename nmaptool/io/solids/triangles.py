"""Triangles back from a file that was just written."""

from __future__ import annotations

import itertools
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.io.meshes.headers import STL_HEADER
from nmaptool.io.solids.stl import RECORD
from nmaptool.io.solids.threemf import MODEL_PATH
from nmaptool.types.solid import Nodes

_BAND = 1 << 16
_PIECE_BYTES = 1 << 22
# between the numbers of a line of our own 3MF files
_NOT_NUMBERS = {
    b"<vertex": (b'<vertex x="', b'" y="', b'" z="', b'"/>'),
    b"<triangle": (b'<triangle v1="', b'" v2="', b'" v3="', b'"/>'),
}


def triangles_of(path: Path) -> Iterator[Float64]:
    """(n, 3, 3) float64 corners in mm of the triangles of a file, in bands."""
    match path.suffix.lower():
        case ".stl":
            with path.open("rb") as file:
                file.seek(STL_HEADER)
                while len(records := np.fromfile(file, RECORD, _BAND)):
                    yield records["corners"].astype(np.float64)
        case ".3mf":
            for vertices, faces in _objects_of(path):
                yield from _in_bands(vertices, faces)
        case _:
            from nmaptool.io.meshes.reader import read_mesh  # the readers of all formats take long to load

            mesh = read_mesh(path, max_faces=2**31 - 1)
            yield from _in_bands(mesh.vertices_mm, mesh.faces.astype(np.int64))


def _in_bands(vertices: Float64, faces: Nodes) -> Iterator[Float64]:
    for at in range(0, len(faces), _BAND):
        yield vertices[faces[at : at + _BAND]]


def _objects_of(path: Path) -> Iterator[tuple[Float64, Nodes]]:
    """Vertices and faces of each object of one of our own 3MF files, which have an element on each line."""
    found: dict[bytes, list[Float64]] = {kind: [] for kind in _NOT_NUMBERS}
    with zipfile.ZipFile(path) as archive, archive.open(MODEL_PATH) as file:
        while lines := file.readlines(_PIECE_BYTES):
            text, kind = b"".join(lines), _kind(lines[0])
            if kind in found and text.count(kind) == len(lines):  # most pieces are of one kind
                found[kind].append(_numbers(text, kind))
                continue
            for kind, run in itertools.groupby(lines, key=_kind):
                if kind in found:
                    found[kind].append(_numbers(b"".join(run), kind))
                elif found[b"<triangle"] and any(b"</object>" in line for line in run):
                    vertices, faces = (np.concatenate(each).reshape(-1, 3) for each in found.values())
                    found = {kind: [] for kind in _NOT_NUMBERS}
                    yield vertices, faces.astype(np.int64)


def _kind(line: bytes) -> bytes:
    return line[: line.find(b" ")]


def _numbers(lines: bytes, kind: bytes) -> Float64:
    """The numbers of lines of one kind."""
    for words in _NOT_NUMBERS[kind]:
        lines = lines.replace(words, b" ")
    return np.fromstring(lines.decode("ascii"), np.float64, sep=" ")

"""Triangles back from OBJ and 3MF files that were just written, with an element on each line."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.core.arrays import Float64
from nmaptool.io.solids import obj, threemf
from nmaptool.io.solids.bands import Triangles, UnreadableError

_PIECE_BYTES = 1 << 20


def objects_of_obj(path: Path) -> Iterator[Triangles]:
    """The triangles of one of our own OBJ files."""
    with path.open("rb") as file:
        yield from _Lines(file, obj.VERTEX, obj.FACE, b"o ", 1).triangles()


def objects_of_3mf(path: Path) -> Iterator[Triangles]:
    """The triangles of one of our own 3MF files."""
    try:
        with zipfile.ZipFile(path) as archive, archive.open(threemf.MODEL_PATH) as file:
            yield from _Lines(file, threemf.VERTEX, threemf.TRIANGLE, b"<object ", None).triangles()
    except (zipfile.BadZipFile, zlib.error, EOFError, KeyError) as error:
        raise UnreadableError(f"it cannot be unpacked ({error})") from None


@dataclass
class _Lines:
    """Lines of vertices and faces, and others.

    Attributes
    ----------
    file : binary file
    vertex, face : bytes
        What stands around the numbers, as in `nmaptool.io.solids.text.words_of`.
    new_object : bytes
        How a line begins that begins an object.
    first : int, optional
        Number of the first vertex, if numbers go on from object to object; by default each begins at 0.
    """

    file: IO[bytes]
    vertex: bytes
    face: bytes
    new_object: bytes
    first: int | None
    vertices: list[Float64] = field(default_factory=list)
    vertices_before: int = 0

    def triangles(self) -> Iterator[Triangles]:
        """All triangles, in bands."""
        points: Float64 | None = None
        for text in self._pieces():
            at = 0
            while at < len(text):
                vertices, at = self._rows(kernels.read_decimal_rows, text, at, self.vertex, 0, np.float64)
                if len(vertices):
                    self.vertices.append(vertices)
                faces, at = self._rows(kernels.read_whole_rows, text, at, self.face, self._first(), np.int32)
                if len(faces):
                    points = self._points() if points is None else points
                    yield Triangles(points, faces.view(np.uint8))
                if not len(vertices) and not len(faces):
                    end = text.find(b"\n", at) + 1 or len(text)
                    if self._begins_object(text[at:end]):
                        self.vertices_before += 0 if points is None else len(points)
                        self.vertices, points = [], None
                    at = end

    def _first(self) -> int:
        """What is subtracted from the numbers of vertices in the file."""
        return 0 if self.first is None else self.first + self.vertices_before

    def _points(self) -> Float64:
        if not self.vertices:
            raise UnreadableError("it has triangles without vertices")
        return np.concatenate(self.vertices)

    def _rows(
        self, read: Callable[..., float], text: bytes, at: int, words: bytes, first: int, kind: type[Any]
    ) -> tuple[NDArray[Any], int]:
        """The rows of one kind from a place on, and the place after them."""
        start = words[: words.index(b"\0")]
        if not text.startswith(start, at):
            return np.empty((0, 3), kind), at
        # a number has at least one digit; the words have four zero bytes
        out, state = np.empty(((len(text) - at) // (len(words) - 1), 3), kind), np.array([at, 0])
        read(text, words, first, out, state)
        end, count = state.tolist()
        if count:
            return out[:count].copy(), end
        end = text.find(b"\n", at) + 1 or len(text)
        return np.array([_unusual(text[at:end], words, kind)], kind) - kind(first), end

    def _begins_object(self, line: bytes) -> bool:
        return line.startswith(self.new_object)

    def _pieces(self) -> Iterator[bytes]:
        """The text, in pieces of whole lines."""
        rest = b""
        while piece := self.file.read(_PIECE_BYTES):
            end = piece.rfind(b"\n") + 1
            if end:
                yield rest + piece[:end]
                rest = piece[end:]
            else:
                rest += piece
        if rest:
            yield rest


def _unusual(line: bytes, words: bytes, kind: type[Any]) -> list[Any]:
    """The numbers of a row with more digits or a greater exponent than the loop reads.

    Raises
    ------
    UnreadableError
        If it is no such row.
    """
    row = re.fullmatch(rb"([^ \"]+)".join(map(re.escape, words.split(b"\0")[:4])), line)
    try:
        if row is not None:
            return [kind(number) for number in row.groups()]
    except (ValueError, OverflowError):
        pass
    raise UnreadableError(f"it has the line {line[:80].decode('ascii', 'replace').strip()!r}")

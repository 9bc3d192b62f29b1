"""Read PLY, text and binary: positions, polygons of any size and triangle strips."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.ply_lines import declared_values
from nmaptool.io.meshes.polygons import Integers, fans, strips
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.words import line_feeds, numbers

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float16": "f2",
    "float32": "f4",
    "float64": "f8",
}
_WANTED = ("vertex", "face", "tristrips")
_PADDING = 8  # bytes that a writer may append
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_ORDERS = {b"binary_little_endian": "<", b"binary_big_endian": ">", b"ascii": ""}
_HEADER_END = re.compile(rb"^end_header[ \t]*(\r\n|\n|\r|\Z)", re.MULTILINE)


@dataclass(frozen=True)
class _Property:
    """One value per row, or a list if ``count``, the type of its length, is given."""

    name: str
    dtype: np.dtype[Any]
    count: np.dtype[Any] | None = None

    @property
    def is_list(self) -> bool:
        """Whether each row has a list of values."""
        return self.count is not None

    @property
    def least(self) -> int:
        """Smallest number of bytes that it takes in a row."""
        return (self.count or self.dtype).itemsize


@dataclass
class _Element:
    name: str
    rows: int
    properties: list[_Property] = field(default_factory=list)

    @property
    def least(self) -> int:
        """Smallest number of bytes of a row."""
        return sum(p.least for p in self.properties)

    @property
    def has_lists(self) -> bool:
        return any(p.count is not None for p in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """The elements in the header, in order, the offset of the data, and whether they are text."""

    elements: list[_Element]
    offset: int
    is_ascii: bool

    @property
    def faces(self) -> int:
        """Declared number of faces."""
        return sum(e.rows for e in self.elements if e.name == "face")


def read_header(file: MeshFile) -> PlyHeader:
    """Read the header within the first bytes of a PLY file.

    Raises
    ------
    InputError
        If it is damaged or incomplete.
    """
    end = _HEADER_END.search(file.head.replace(b"\r", b"\n") if b"\n" not in file.head[:8] else file.head)
    if end is None:
        raise file.damaged
    order, elements = None, list[_Element]()
    try:
        for line in file.head[: end.start()].splitlines():
            words = line.split()
            if words[:1] == [b"format"]:
                order = _ORDERS[words[1]]
            elif words[:1] == [b"element"]:
                elements.append(_Element(words[1].decode("latin-1"), int(words[2])))
            elif words[:1] == [b"property"]:
                elements[-1].properties.append(_property(words, order))
    except (KeyError, IndexError, ValueError, TypeError):
        raise file.damaged from None
    if order is None or any(e.rows < 0 or (e.rows and not e.properties) for e in elements):
        raise file.damaged
    return PlyHeader(elements, end.end(), order == "")


def _property(words: list[bytes], order: str | None) -> _Property:
    if order is None:
        raise ValueError
    names = [word.decode("latin-1") for word in words]
    # all text is converted to float64 and then read as binary
    types = [np.dtype("=f8" if order == "" else order + _TYPES[name]) for name in names[-2:0:-1] if name != "list"]
    return _Property(names[-1], types[0], types[1] if names[1] == "list" else None)


def read_ply(file: MeshFile, max_faces: int) -> Surface:
    """Read a PLY; its indices are not checked.

    Raises
    ------
    InputError
        If it is truncated or damaged.
    LimitError
        If it declares more than ``max_faces``.
    """
    header = read_header(file)
    _check_claim(file, header, max_faces)
    data = file.read_bytes()
    body = data[header.offset :]
    if not header.is_ascii:
        return _read_elements(file, header, body)
    try:
        return _read_elements(file, header, numbers(body, np.float64).tobytes())
    except (InputError, LookupError, TypeError, ValueError):
        line = line_feeds(data[: header.offset]).count(b"\n")
        kept, notes = declared_values(header.elements, body, line)
        if not notes:
            raise
        return replace(_read_elements(file, header, numbers(kept, np.float64).tobytes()), notes=notes)


def _check_claim(file: MeshFile, header: PlyHeader, max_faces: int) -> None:
    """Refuse a file that declares too many faces, or more rows than its size allows."""
    file.check_limit(header.faces, max_faces)
    # in text, each value of 8 bytes takes at least a digit and a blank; the last one needs no blank
    least = sum(e.rows * (e.least // 4 if header.is_ascii else e.least) for e in header.elements)
    if header.offset + least > file.size + header.is_ascii:
        raise file.damaged


def _read_elements(file: MeshFile, header: PlyHeader, body: bytes) -> Surface:
    vertices: Float64 = np.zeros((0, 3))
    pieces: list[Integers] = []
    made: list[Integers] = []
    offset = 0
    last = max((i for i, e in enumerate(header.elements) if e.name in _WANTED), default=-1)
    for element in header.elements[: last + 1]:
        rows, lists, offset = _rows(element, body, offset)
        if element.name == "vertex" and element.rows:
            if rows is None:
                raise file.damaged  # lists in vertices, which no program writes
            vertices = np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)
        elif lists is not None and element.name != "vertex" and element.name in _WANTED:
            if not lists[0].all():  # a face without corners: bytes are missing or shifted
                raise file.damaged
            pieces.append((fans if element.name == "face" else strips)(*lists))
            polygons = element.name == "face"
            made.append(np.maximum(lists[0] - 2, 0) if polygons else np.ones(len(pieces[-1]), np.int64))
    left = len(body) - offset
    # with more data than declared, faces would be lost or bytes are shifted
    if last == len(header.elements) - 1 and left > (0 if header.is_ascii else _PADDING):
        raise file.damaged
    if not pieces:
        return Surface(vertices, np.zeros((0, 3), np.int64))
    return Surface(vertices, np.concatenate(pieces), np.concatenate(made))


def _rows(
    element: _Element, body: bytes, offset: int
) -> tuple[NDArray[np.void] | None, tuple[Integers, Integers] | None, int]:
    """The rows if they have no lists, else the lengths and values of the index lists; and the offset after them."""
    wanted = _index_list(element)
    if not element.rows:
        return None, None, offset
    lengths = _first_lengths(element, body, offset)
    row = _table_type(element, lengths)
    end = offset + row.itemsize * element.rows
    if end <= len(body):
        table = np.frombuffer(body, row, element.rows, offset)
        if not element.has_lists:
            return table, None, end
        if all((table[f"n{i}"] == n).all() for i, n in enumerate(lengths) if element.properties[i].count is not None):
            counts = np.full(element.rows, lengths[wanted], np.int64)
            return None, (counts, _indices(table[f"p{wanted}"].reshape(-1))), end
    counts, values, end = _walk(element, body, offset, wanted)
    return None, (counts, values), end


def _index_list(element: _Element) -> int:
    lists = [i for i, p in enumerate(element.properties) if p.count is not None]
    named = [i for i in lists if element.properties[i].name in _INDEX_NAMES]
    return (named or lists or [0])[0]


def _first_lengths(element: _Element, body: bytes, offset: int) -> list[int]:
    """The number of values of each property in the first row, which must be complete."""
    lengths = []
    for prop in element.properties:
        n = 1
        if prop.count is not None:
            n = int(np.frombuffer(body, prop.count, 1, offset)[0])
            offset += prop.count.itemsize
        offset += n * prop.dtype.itemsize
        if n < 0 or offset > len(body):
            raise ValueError
        lengths.append(n)
    return lengths


def _table_type(element: _Element, lengths: list[int]) -> np.dtype[np.void]:
    fields: list[tuple[str, object]] = []
    for i, (prop, n) in enumerate(zip(element.properties, lengths, strict=True)):
        if prop.count is None:
            # of properties with the same name, the first one counts
            first = all(prop.name != p.name for p in element.properties[:i])
            fields.append((prop.name if first and not element.has_lists else f"p{i}", prop.dtype))
        else:
            fields += [(f"n{i}", prop.count), (f"p{i}", (prop.dtype, (n,)))]
    return np.dtype(fields)


def _walk(element: _Element, body: bytes, offset: int, wanted: int) -> tuple[Integers, Integers, int]:
    """Read row by row, for lists of different lengths."""
    counts: list[int] = []
    parts: list[bytes] = []
    readers = [(p.count, p.least, p.dtype.itemsize, i == wanted) for i, p in enumerate(element.properties)]
    for _ in range(element.rows):
        for count, least, width, is_wanted in readers:
            start = offset + least
            if count is not None:
                n = int(np.frombuffer(body, count, 1, offset)[0])
                offset = start + n * width
                if n < 0 or offset > len(body):
                    raise ValueError
                if is_wanted:
                    counts.append(n)
                    parts.append(body[start:offset])
            else:
                offset = start
    values = np.frombuffer(b"".join(parts), element.properties[wanted].dtype)
    return np.array(counts, np.int64), _indices(values), offset


def _indices(values: NDArray[Any]) -> Integers:
    if values.dtype.kind == "f" and not ((np.abs(values) < 2**53) & (np.trunc(values) == values)).all():
        raise ValueError
    return values.astype(np.int64)

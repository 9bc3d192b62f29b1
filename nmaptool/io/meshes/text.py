"""OBJ, OFF and ASCII STL brought to the plainest form of their kind, which trimesh reads without guessing.

Left to itself it takes relative indices from the end of the file, vertex 0 for vertex 1, a face cut short for a smaller
one, and a name for a command; and it opens the materials that an OBJ names.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile

_COORDINATES = rb"(\S+[ \t]+\S+[ \t]+\S+)"
_OBJ_VERTEX = re.compile(rb"^[ \t]*v[ \t]+" + _COORDINATES, re.MULTILINE)
_OBJ_VERTEX_LINE = re.compile(rb"^[ \t]*v(?=[ \t\n]|\Z)", re.MULTILINE)
_OBJ_FACE = re.compile(rb"^[ \t]*f(?=[ \t\n]|\Z)[ \t]*([^\n#]*)", re.MULTILINE)
_OBJ_EITHER = re.compile(rb"^[ \t]*(?:(v)[ \t]|f[ \t]+([^\n#]*))", re.MULTILINE)
_ZERO = re.compile(rb"(?<![\d.+-])0+(?![\d.])")
_OFF_HEADER = re.compile(rb"\s*(?:ST)?C?N?OFF\b[ \t]*(BINARY\b)?")
_STL_NAME = re.compile(rb"^[ \t]*(end)?solid\b[^\n]*", re.MULTILINE | re.IGNORECASE)
_STL_VERTEX = re.compile(rb"\bvertex\s+(\S+\s+\S+\s+\S+)", re.IGNORECASE)
_STL_WORD = {word: re.compile(rb"\b%b\b" % word, re.IGNORECASE) for word in (b"facet", b"endfacet", b"vertex")}


@dataclass(frozen=True)
class PlainMesh:
    """The numbers of a text file, still as text.

    Attributes
    ----------
    vertices : list of bytes
        ``x y z`` of each.
    triangles : list of bytes
        ``a b c`` of each, counted from ``base``.
    base : int
        Number of the first vertex.
    made : list of int
        How many triangles each polygon was cut into, in order.
    """

    vertices: list[bytes]
    triangles: list[bytes]
    base: int
    made: list[int]

    def encoded(self, kind: str) -> bytes:
        """The same as a file of its kind."""
        if kind == "obj":
            return b"v " + b"\nv ".join(self.vertices) + b"\nf " + b"\nf ".join(self.triangles) + b"\n"
        if kind == "off":
            counts = b"OFF\n%d %d 0\n" % (len(self.vertices), len(self.triangles))
            return counts + b"\n".join(self.vertices) + b"\n3 " + b"\n3 ".join(self.triangles) + b"\n"
        return b"solid\nvertex " + b"\nvertex ".join(self.vertices) + b"\nendsolid\n"

    def missing_vertex(self) -> int | None:
        """The first number in a triangle that is no vertex's; None if there is none, or something else is wrong."""
        try:
            numbers = (int(number) for triangle in self.triangles for number in triangle.split())
            return next((n for n in numbers if not self.base <= n < self.base + len(self.vertices)), None)
        except ValueError:
            return None


def _lines_of(data: bytes) -> bytes:
    """With one kind of line end, and without a byte order mark."""
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data.removeprefix(b"\xef\xbb\xbf")


def _fan(corners: list[bytes]) -> list[bytes]:
    return [b" ".join((corners[0], *corners[i : i + 2])) for i in range(1, len(corners) - 1)]


def plain_obj(file: MeshFile, data: bytes) -> PlainMesh:
    """Positions and triangles of an OBJ; everything else in it is left out.

    Raises
    ------
    InputError
        If a line is incomplete, or an index is zero or reaches back beyond the first vertex.
    """
    text = _lines_of(data)
    if b"\\\n" in text:
        text = text.replace(b"\\\n", b" ")
    vertices = _OBJ_VERTEX.findall(text)
    if len(vertices) != len(_OBJ_VERTEX_LINE.findall(text)):
        raise file.damaged
    faces = _OBJ_FACE.findall(text)
    joined = b"\n".join(faces)
    if b"-" in joined:
        faces = _absolute(file, text)
        joined = b"\n".join(faces)
    if b"/" in joined:
        joined = re.sub(rb"/\S*", b"", joined)
    if _ZERO.search(joined):
        raise InputError(f"{file.path}: a face names vertex 0, but OBJ files count from 1; export it again")
    triangles: list[bytes] = []
    made: list[int] = []
    corners: list[bytes] = [b""] * 3
    for line in joined.split(b"\n") if faces else ():
        corners = line.split()
        if len(corners) == 3:
            triangles.append(line)
        else:
            triangles += _fan(corners)
        made.append(max(len(corners) - 2, 0))
    last = text[text.rfind(b"\n") + 1 :]
    if len(corners) < 3 and last.lstrip().startswith(b"f"):
        raise file.damaged
    return PlainMesh(vertices, triangles, 1, made)


def _absolute(file: MeshFile, text: bytes) -> list[bytes]:
    """Faces with each index that counts back from the last vertex before it counted from the first."""
    seen, faces = 0, []
    for match in _OBJ_EITHER.finditer(text):
        if match[1]:
            seen += 1
            continue
        corners = []
        for corner in match[2].split():
            index = corner.partition(b"/")[0]
            if index.startswith(b"-"):
                if not index[1:].isdigit():
                    raise file.damaged
                back = int(index[1:19])
                if back > seen:
                    raise file.names_missing_vertex(-back, seen)
                # -0 stays what it is, so that it is refused as 0
                index = b"%d" % (seen - back + 1 if back else 0)
            corners.append(index)
        faces.append(b" ".join(corners))
    return faces


def off_counts(file: MeshFile, text: bytes) -> tuple[int, int, int]:
    """Vertices and faces that the header of an OFF claims, and where what follows begins.

    Raises
    ------
    InputError
        If the header is damaged, or the data are binary.
    """
    header = _OFF_HEADER.match(text)
    if header is None:
        raise file.damaged
    if header[1]:
        raise InputError(f"{file.path}: holds binary OFF data; export it as text, or as PLY")
    counts = re.compile(rb"\s*(\d{1,18})[ \t]+(\d{1,18})(?:[ \t]+\d+)?[ \t]*(?:\n|\Z)").match(text, header.end())
    if counts is None:
        raise file.damaged
    return int(counts[1]), int(counts[2]), counts.end()


def without_comments(data: bytes) -> bytes:
    """An OFF's text, with one kind of line end."""
    text = _lines_of(data)
    return re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text


def plain_off(file: MeshFile, data: bytes) -> PlainMesh:
    """Positions and triangles of an OFF; normals and colours are left out.

    Raises
    ------
    InputError
        If other lines or fewer numbers are there than announced.
    """
    text = without_comments(data)
    vertices, faces, start = off_counts(file, text)
    lines = [line for line in text[start:].split(b"\n") if line and not line.isspace()]
    if len(lines) != vertices + faces:
        raise file.damaged
    positions = [b" ".join(line.split(None, 3)[:3]) for line in lines[:vertices]]
    triangles: list[bytes] = []
    made: list[int] = []
    for line in lines[vertices : vertices + faces]:
        corners = line.split()
        if not corners[0].isdigit():
            raise file.damaged
        size = int(corners[0][:18])
        if len(corners) <= size:
            raise file.damaged
        triangles += _fan(corners[1 : size + 1])
        made.append(max(size - 2, 0))
    return PlainMesh(positions, triangles, 0, made)


def plain_stl(file: MeshFile, data: bytes) -> PlainMesh:
    """Corners of an ASCII STL, three to a face; its normals and names are left out.

    Raises
    ------
    InputError
        If it does not end as it should, or a face has not three corners.
    """
    text = _lines_of(data)
    if b"end" not in (match[1].lower() for match in _STL_NAME.finditer(text) if match[1]):
        raise InputError(f"{file.path}: the STL file is cut short: its end is missing; export or download it again")
    text = _STL_NAME.sub(b"", text)
    corners = [b" ".join(corner.split()) for corner in _STL_VERTEX.findall(text)]
    counted = {word: len(pattern.findall(text)) for word, pattern in _STL_WORD.items()}
    if not counted[b"facet"] == counted[b"endfacet"] == counted[b"vertex"] / 3 == len(corners) / 3:
        raise file.damaged
    return PlainMesh(corners, [b""] * (len(corners) // 3), 0, [])

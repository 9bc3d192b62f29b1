"""Binary STL, band by band."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.types.solid import Part, Solid

# eighty bytes of text, which must not begin with "solid"
_HEADER = b"binary STL by nmaptool, mm".ljust(80)
# x, y and z of a number of points
Place = tuple[Float32, Float32, Float32]
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(solid: Solid, path: Path) -> None:
    """Write all bodies as one binary STL in mm."""
    with path.open("wb") as file:
        file.write(_HEADER + np.uint32(solid.face_count).tobytes())
        for body in solid.bodies:
            for part in body.parts():
                file.write(_records(part).data)


def _records(part: Part) -> NDArray[np.uint8]:
    """(m, 50) bytes: the triangles of a part, with their normals."""
    # coordinate by coordinate, because NumPy is slow on rows of three
    x, y, z = np.ascontiguousarray(part.xyz_mm.T, np.float32)
    corners = [(x[c], y[c], z[c]) for c in np.ascontiguousarray(part.faces.T)]
    numbers = np.empty((len(part.faces), 12), np.float32)
    for axis, values in enumerate(_unit_normals(*corners)):
        numbers[:, axis] = values
    for corner, place in enumerate(corners, start=1):
        for axis, values in enumerate(place):
            numbers[:, 3 * corner + axis] = values
    records = np.zeros((len(numbers), RECORD.itemsize), np.uint8)
    records[:, :48] = numbers.astype("<f4", copy=False).view(np.uint8)
    return records


def _unit_normals(a: Place, b: Place, c: Place) -> Place:
    """The coordinates of the unit normals of triangles."""
    first, second = [q - p for p, q in zip(a, b, strict=True)], [q - p for p, q in zip(a, c, strict=True)]
    x = first[1] * second[2] - first[2] * second[1]
    y = first[2] * second[0] - first[0] * second[2]
    z = first[0] * second[1] - first[1] * second[0]
    length = np.maximum(np.sqrt(x * x + y * y + z * z), np.finfo(np.float32).tiny)
    return x / length, y / length, z / length

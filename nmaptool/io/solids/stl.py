"""Binary STL, band by band."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.types.solid import Part, Solid

# eighty bytes of text, which must not begin with "solid"
_HEADER = b"binary STL by nmaptool, mm".ljust(80)
HEADER_BYTES = len(_HEADER) + 4
# three float32 for the normal and nine for the corners, two bytes for the attribute
RECORD_BYTES, CORNERS_AT = 50, 12


def write_stl(solid: Solid, path: Path) -> None:
    """Write all bodies as one binary STL in mm."""
    with path.open("wb") as file:
        file.write(_HEADER + np.uint32(solid.face_count).tobytes())
        for body in solid.bodies:
            for part in body.parts():
                file.write(_records(part).data)


def _records(part: Part) -> NDArray[np.uint8]:
    """(m, 50) bytes: the triangles of a part, with their normals."""
    records = np.empty((len(part.faces), RECORD_BYTES), np.uint8)
    kernels.stl_records(
        np.ascontiguousarray(part.xyz_mm, np.float64), np.ascontiguousarray(part.faces, np.int32), records
    )
    return records

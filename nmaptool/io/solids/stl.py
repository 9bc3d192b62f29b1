"""Binary STL, band by band."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.types.solid import Part, Solid

# eighty bytes of text, which must not begin with "solid"
_HEADER = b"binary STL by nmaptool, mm".ljust(80)
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(solid: Solid, path: Path) -> None:
    """Write all bodies as one binary STL in mm."""
    with path.open("wb") as file:
        file.write(_HEADER + np.uint32(solid.face_count).tobytes())
        for body in solid.bodies:
            for part in body.parts():
                file.write(_records(part).tobytes())


def _records(part: Part) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """The triangles of a part, with their normals."""
    corners = part.xyz_mm.astype(np.float32)[part.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    records = np.zeros(len(corners), RECORD)
    records["corners"] = corners
    normal = records["normal"]
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        normal[:, axis] = first[:, b] * second[:, c] - first[:, c] * second[:, b]
    length = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    normal /= np.maximum(length, np.finfo(np.float32).tiny)[:, None]
    return records

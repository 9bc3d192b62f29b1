"""Binary PLY, band by band."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.types.solid import NumberedBody, Solid

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_ply(solid: Solid, path: Path) -> None:
    """Write all bodies as one binary PLY in mm."""
    bodies = [NumberedBody.of(body) for body in solid.bodies]
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment nmaptool, mm\n"
        f"element vertex {sum(body.vertex_count for body in bodies)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {solid.face_count}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    with path.open("wb") as file:
        file.write(header.encode())
        for body in bodies:
            for vertices in body.vertices():
                file.write(vertices.astype("<f4").tobytes())
        first = 0
        for body in bodies:
            for faces in body.faces():
                records = np.empty(len(faces), _FACE)
                records["count"] = 3
                records["corners"] = faces + first
                file.write(records.tobytes())
            first += body.vertex_count

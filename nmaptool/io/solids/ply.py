"""Binary PLY, band by band."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.types.solid import NumberedBody, Solid

FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_ply(solid: Solid, path: Path) -> None:
    """Write all bodies as one binary PLY in mm."""
    bodies = [NumberedBody.of(body) for body in solid.bodies]
    header = header_of(sum(body.vertex_count for body in bodies), solid.face_count)
    with path.open("wb") as file:
        file.write(header)
        for body in bodies:
            for vertices in body.vertices():
                file.write(vertices.astype("<f4").tobytes())
        first = 0
        for body in bodies:
            for faces in body.faces():
                records = np.empty(len(faces), FACE)
                records["count"] = 3
                records["corners"] = faces + first
                file.write(records.tobytes())
            first += body.vertex_count


def header_of(vertex_count: int, face_count: int) -> bytes:
    """The text before the data."""
    return (
        "ply\nformat binary_little_endian 1.0\ncomment nmaptool, mm\n"
        f"element vertex {vertex_count}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {face_count}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()

"""Sizes of files of triangles, before they are written."""

from __future__ import annotations

from nmaptool.io.solids.ply import FACE, header_of
from nmaptool.io.solids.stl import HEADER_BYTES, RECORD_BYTES
from nmaptool.types.solid import NumberedBody, Solid

# bytes per triangle of the files whose size is not known before, with a vertex for every two triangles
_ABOUT = {".ply": 19.0, ".obj": 42.0, ".glb": 18.0, ".3mf": 14.0}


def about_bytes(ending: str, face_count: int) -> float:
    """The size of a file of so many triangles: exact for .stl, about that for others; 0 if it is not known."""
    if ending == ".stl":
        return float(HEADER_BYTES + RECORD_BYTES * face_count)
    return _ABOUT.get(ending, 0.0) * face_count


def exact_bytes(ending: str, solid: Solid) -> int | None:
    """The size of a file of a solid, where it follows from its vertices and triangles; None where it does not."""
    faces = solid.face_count
    if ending == ".stl":
        return HEADER_BYTES + RECORD_BYTES * faces
    if ending == ".ply":
        vertices = sum(NumberedBody.of(body).vertex_count for body in solid.bodies)
        return len(header_of(vertices, faces)) + 12 * vertices + FACE.itemsize * faces
    return None

"""What cleaning a mesh changed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MeshFindings:
    """Counts of what was dropped, welded or flipped in a mesh.

    Attributes
    ----------
    vertices, faces : int
        Numbers in the file.
    welded_vertices : int
        Vertices at the position of another vertex.
    unreferenced_vertices : int
        Finite vertices that no face uses.
    nonfinite_vertices, nonfinite_faces : int
        Vertices that are NaN or infinite, and the faces that use them.
    degenerate_faces : int
        Faces without area.
    repeated_faces : int
        Faces with the same vertices as another face.
    turned_faces : int
        Faces wound opposite to their neighbours, which were flipped.
    """

    vertices: int
    faces: int
    welded_vertices: int = 0
    unreferenced_vertices: int = 0
    nonfinite_vertices: int = 0
    nonfinite_faces: int = 0
    degenerate_faces: int = 0
    repeated_faces: int = 0
    turned_faces: int = 0

"""What cleaning a mesh removed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MeshFindings:
    """What was found in a mesh and dropped.

    Attributes
    ----------
    vertices, faces : int
        As the file holds them.
    welded_vertices : int
        Duplicates of another vertex's position.
    unreferenced_vertices : int
        Finite ones that no face names.
    nonfinite_vertices, nonfinite_faces : int
        Vertices that are NaN or infinite, and the faces that use them.
    degenerate_faces : int
        Without area.
    repeated_faces : int
        With the same vertices as another.
    turned_faces : int
        Wound the other way than their neighbours, and turned.
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

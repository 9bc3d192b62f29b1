"""What cleaning a mesh changed."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.types.shown import counted


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

    def summary(self) -> str:
        """What was read and what was changed, in one line.

        >>> MeshFindings(vertices=4, faces=2, welded_vertices=1, degenerate_faces=1).summary()
        '4 vertices, 2 faces; 1 vertex welded, 1 face without area'
        """
        changes = (
            (self.welded_vertices, "vertex", " welded"),
            (self.degenerate_faces, "face", " without area"),
            (self.nonfinite_faces, "face", " with NaN"),
            (self.repeated_faces, "duplicate face", ""),
            (self.turned_faces, "face", " flipped to match neighbouring faces"),
            (self.unreferenced_vertices, "vertex", " unused"),
        )
        dropped = ", ".join(f"{counted(count, what)}{more}" for count, what, more in changes if count)
        size = f"{counted(self.vertices, 'vertex')}, {counted(self.faces, 'face')}"
        return f"{size}; {dropped}" if dropped else size

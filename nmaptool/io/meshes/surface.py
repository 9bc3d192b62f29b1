"""The data that every reader of a mesh file returns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers, fans
from nmaptool.io.meshes.words import numbers


def _none() -> Integers:
    return np.zeros(0, np.int64)


@dataclass(frozen=True)
class Surface:
    """Vertices and triangles of a file.

    Attributes
    ----------
    vertices : (N, 3) float64
        As in the file; they may be NaN.
    triangles : (M, 3) int64
        Polygons are cut from their first corner. Indices are counted from 0 and not checked yet.
    made : (P,) int64
        Number of triangles of each polygon, for `nmaptool.io.meshes.polygons.recut`; empty if all are triangles.
    notes : tuple of str
        What the reader ignored or assumed, one sentence each.
    mm_per_unit : float or None
        Millimetres per unit of the vertices; None if the file does not say.
    is_y_up : bool
        Whether the format or the file says that y points up, or the reader turned the mesh so.
    """

    vertices: Float64
    triangles: Integers
    made: Integers = field(default_factory=_none)
    notes: tuple[str, ...] = ()
    mm_per_unit: float | None = None
    is_y_up: bool = False


@dataclass(frozen=True)
class TextPolygons:
    """Polygons of a text or of a piece of one. Coordinates stay text until everything else has been checked.

    Attributes
    ----------
    coordinates : bytes
        ``x y z`` of each vertex.
    vertices : int
        Number of vertices.
    sizes : (P,) int64
        Number of corners of each polygon; polygons with fewer than three are dropped.
    corners : (sum of sizes,) int64
        Vertex indices of the corners, counted as in the file.
    """

    coordinates: bytes
    vertices: int
    sizes: Integers
    corners: Integers

    @classmethod
    def joined(cls, pieces: list[TextPolygons]) -> TextPolygons:
        """Join the pieces of a text."""
        return cls(
            b" ".join(piece.coordinates for piece in pieces),
            sum(piece.vertices for piece in pieces),
            np.concatenate([piece.sizes for piece in pieces]),
            np.concatenate([piece.corners for piece in pieces]),
        )

    def surface(self, file: MeshFile, base: int, max_faces: int) -> Surface:
        """Make vertices and triangles; ``base`` is the file's index of the first vertex.

        Raises
        ------
        InputError
            If there are no triangles, or one refers to a vertex that does not exist.
        LimitError
            If there are more than ``max_faces``.
        ValueError
            If a coordinate is not a number.
        """
        made = np.maximum(self.sizes - 2, 0)
        file.check_limit(int(made.sum()), max_faces)
        triangles = fans(self.sizes, self.corners)
        if not len(triangles):
            raise file.holds_no_faces(self.vertices)
        missing = (triangles < base) | (triangles >= base + self.vertices)
        if missing.any():
            raise file.names_missing_vertex(int(triangles[missing][0]), self.vertices)
        points = numbers(self.coordinates, np.float64, 3 * self.vertices)
        return Surface(points.reshape(-1, 3), triangles - base, made)

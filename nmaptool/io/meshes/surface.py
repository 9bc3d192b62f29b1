"""What every reader of a mesh file hands on."""

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
        As the file has them; they may be NaN.
    triangles : (M, 3) int64
        Polygons are cut from their first corner. Indices are those of the file, counted from 0, and may be wrong.
    made : (P,) int64
        How many triangles each polygon became, for `nmaptool.io.meshes.polygons.recut`; empty if all are triangles.
    """

    vertices: Float64
    triangles: Integers
    made: Integers = field(default_factory=_none)


@dataclass(frozen=True)
class TextPolygons:
    """Polygons of a text or of a piece of one. Coordinates stay text until all else is known to be right.

    Attributes
    ----------
    coordinates : bytes
        ``x y z`` of each vertex.
    vertices : int
        How many there are.
    sizes : (P,) int64
        Corners of each polygon; what has fewer than three is left out.
    corners : (sum of sizes,) int64
        Their vertices, numbered as in the file.
    """

    coordinates: bytes
    vertices: int
    sizes: Integers
    corners: Integers

    @classmethod
    def joined(cls, pieces: list[TextPolygons]) -> TextPolygons:
        """The polygons of a whole text."""
        return cls(
            b" ".join(piece.coordinates for piece in pieces),
            sum(piece.vertices for piece in pieces),
            np.concatenate([piece.sizes for piece in pieces]),
            np.concatenate([piece.corners for piece in pieces]),
        )

    def surface(self, file: MeshFile, base: int, max_faces: int) -> Surface:
        """Vertices and triangles; ``base`` is the number of the first vertex.

        Raises
        ------
        InputError
            If there are no triangles, or one names a vertex that is not there.
        LimitError
            If there are more than ``max_faces``.
        ValueError
            If a coordinate is no number.
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

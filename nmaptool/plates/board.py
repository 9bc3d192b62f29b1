"""The grid of a plate: where its vertices lie, and their distances from its edge."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.plates.distance import Curves, Nearest, inside_grid
from nmaptool.plates.polygons import refined
from nmaptool.types.contours import Contours

# pixels beyond the outline, where heights continue
BEYOND_PX = 3


@dataclass(frozen=True, eq=False)
class Board:
    """A grid of pixels that covers a plate, in line with the pixels of the picture on it.

    Attributes
    ----------
    left, bottom : int
        Pixels of the grid to the left of the picture, and below it; negative where the picture is cropped.
    rows, cols : int
    pitch_mm : float
    """

    left: int
    bottom: int
    rows: int
    cols: int
    pitch_mm: float

    @classmethod
    def around(cls, outline: Contours, pitch_mm: float) -> Board:
        """The grid around an outline in mm from the lower left corner of the picture."""
        low, high = outline.bounds_mm / pitch_mm
        left, bottom = (-int(np.floor(each)) + BEYOND_PX for each in low)
        right, top = (int(np.ceil(each)) + BEYOND_PX for each in high)
        return cls(left, bottom, top + bottom, right + left, pitch_mm)

    def placed(self, contours: Contours) -> Contours:
        """Curves in mm from the lower left corner of the picture, from that of the grid instead."""
        return contours.moved(self.left * self.pitch_mm, self.bottom * self.pitch_mm)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of vertices."""
        return self.rows + 1, self.cols + 1

    @cached_property
    def x_mm(self) -> Float64:
        """(cols + 1,) of the vertices, from the lower left corner of the grid."""
        return np.arange(self.cols + 1.0) * self.pitch_mm

    @cached_property
    def y_mm(self) -> Float64:
        """(rows + 1,) of the vertices, from the lower left corner of the grid."""
        return (self.rows - np.arange(self.rows + 1.0)) * self.pitch_mm

    def pixels_inside(self, outline: Contours) -> Mask:
        """(rows, cols) bool: the pixels whose middles lie inside."""
        half = self.pitch_mm / 2
        return inside_grid(outline, self.x_mm[:-1] + half, self.y_mm[1:] + half)

    def field(self, contours: Contours, reach_mm: float) -> Field:
        """Distances of the vertices from curves, within a reach."""
        inside = inside_grid(contours, self.x_mm, self.y_mm)
        at = self._near(contours, reach_mm)
        rows, cols = np.divmod(at, self.cols + 1)
        points = np.column_stack([self.x_mm[cols], self.y_mm[rows]])
        return Field(inside, at, Curves(contours, self.pitch_mm).nearest(points, reach_mm))

    def depth_mm(self, contours: Contours, reach_mm: float) -> Float64:
        """(rows, cols) float64: distances of the vertices from curves, positive inside, at most a reach."""
        return np.clip(self.field(contours, reach_mm).depth_mm(), -reach_mm, reach_mm)

    def _near(self, contours: Contours, reach_mm: float) -> NDArray[np.intp]:
        """(n,) the vertices, row by row, that may lie within a reach of curves: at least all that do."""
        import cv2

        if np.isinf(reach_mm):
            return np.arange(self.shape[0] * self.shape[1])
        away = np.ones(self.shape, np.uint8)
        for ring in contours.rings:
            points = refined(ring, self.pitch_mm / 2) / self.pitch_mm
            cols = np.clip(np.rint(points[:, 0]).astype(np.int64), 0, self.cols)
            rows = np.clip(np.rint(self.rows - points[:, 1]).astype(np.int64), 0, self.rows)
            away[rows, cols] = 0
        # a marked vertex is within 0.71 pixels of its point, and that within half a pixel of the nearest one
        distance = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return np.flatnonzero(distance <= reach_mm / self.pitch_mm + 1.5)


@dataclass(frozen=True, eq=False)
class Field:
    """Distances of the vertices of a grid from curves.

    Attributes
    ----------
    inside : (rows, cols) bool
        Of all vertices.
    at : (n,) int
        The vertices, row by row, that ``near`` is of.
    near : Nearest
    """

    inside: Mask
    at: NDArray[np.intp]
    near: Nearest

    def depth_mm(self) -> Float64:
        """(rows, cols) float64: distance from the curves, positive inside; infinite beyond the reach."""
        out = np.where(self.inside, np.inf, -np.inf)
        signed = np.where(self.inside.ravel()[self.at], self.near.distance_mm, -self.near.distance_mm)
        out.ravel()[self.at] = signed
        return out

    def spread(self, values: Float64, beyond: float) -> Float64:
        """(rows, cols) float64: values of ``near`` at their vertices, and another value at all others."""
        out = np.full(self.inside.shape, beyond)
        out.ravel()[self.at] = values
        return out

"""The grid of a plate: where its vertices lie, and their distances from its edge."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.plates.distance import Curves, Nearest, inside_grid
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
        low, high = contours.bounds_mm
        first_col, last_col = np.searchsorted(self.x_mm, [low[0] - reach_mm, high[0] + reach_mm])
        first_row, last_row = np.searchsorted(-self.y_mm, [-high[1] - reach_mm, -low[1] + reach_mm])
        rows, cols = slice(int(first_row), int(last_row)), slice(int(first_col), int(last_col))
        x, y = np.meshgrid(self.x_mm[cols], self.y_mm[rows])
        near = Curves(contours, self.pitch_mm).nearest(np.column_stack([x.ravel(), y.ravel()]), reach_mm)
        return Field(inside, rows, cols, near, x.shape)


@dataclass(frozen=True, eq=False)
class Field:
    """Distances of the vertices of a grid from curves.

    Attributes
    ----------
    inside : (rows, cols) bool
        Of all vertices.
    rows, cols : slice
        The window that ``near`` covers.
    near : Nearest
    window : tuple of int
        Its shape.
    """

    inside: Mask
    rows: slice
    cols: slice
    near: Nearest
    window: tuple[int, ...]

    def depth_mm(self) -> Float64:
        """(rows, cols) float64: distance from the curves, positive inside; infinite beyond the reach."""
        out = np.where(self.inside, np.inf, -np.inf)
        signed = self.near.distance_mm.reshape(self.window)
        out[self.rows, self.cols] = np.where(self.inside[self.rows, self.cols], signed, -signed)
        return out

    def along_mm(self) -> Float64:
        """(rows, cols) float64: where on its ring the nearest point lies; 0 beyond the reach."""
        out = np.zeros(self.inside.shape)
        out[self.rows, self.cols] = self.near.along_mm.reshape(self.window)
        return out

"""Closed curves in millimetres: the outline of a plate, or of letters."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, read_only
from nmaptool.core.errors import InputError
from nmaptool.types.shown import OneLine, counted


@dataclass(frozen=True, eq=False, repr=False)
class Contours(OneLine):
    """Closed polygons that follow curves: outer rings counter-clockwise, holes clockwise.

    Rings neither cross each other nor themselves.

    Parameters
    ----------
    rings : tuple of (n, 2) float64
        Corners in mm, x to the right and y up; the last is joined to the first.
    tolerance_mm : float
        The greatest distance between the polygons and the true curves.

    Raises
    ------
    InputError
        If a ring has less than three corners, or a corner is not finite.
    """

    rings: tuple[Float64, ...]
    tolerance_mm: float = 0.0

    def __post_init__(self) -> None:
        for ring in self.rings:
            if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3 or ring.dtype != np.float64:
                raise InputError(f"a closed curve is {ring.dtype} {ring.shape}; expected float64 (n, 2), n at least 3")
            if not np.isfinite(ring).all():
                raise InputError("the corners of a closed curve must be finite")
        object.__setattr__(self, "rings", tuple(read_only(ring) for ring in self.rings))

    @property
    def area_mm2(self) -> float:
        """The area inside."""
        return float(sum(ring_area(ring) for ring in self.rings))

    @property
    def bounds_mm(self) -> Float64:
        """(2, 2) float64: least and greatest x and y."""
        points = np.concatenate(self.rings)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def moved(self, x_mm: float, y_mm: float) -> Contours:
        """The same curves elsewhere."""
        return dataclasses.replace(self, rings=tuple(ring + np.array([x_mm, y_mm]) for ring in self.rings))

    @staticmethod
    def joined(parts: Iterable[Contours]) -> Contours:
        """Curves that do not cross each other, as one."""
        parts = list(parts)
        rings = tuple(ring for part in parts for ring in part.rings)
        return Contours(rings, max((part.tolerance_mm for part in parts), default=0.0))

    def _line(self) -> str:
        return f"{counted(len(self.rings), 'ring')}, {self.area_mm2:.6g} mm2"


def ring_area(ring: Float64) -> float:
    """Area of a ring in mm2; negative if it runs clockwise.

    >>> ring_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))
    2.0
    """
    x, y = (ring - ring[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)

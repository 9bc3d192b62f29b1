"""A curve in the plane that letters follow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, read_only
from nmaptool.core.errors import InputError
from nmaptool.types.contours import ring_area
from nmaptool.types.shown import OneLine, counted


@dataclass(frozen=True, eq=False, repr=False)
class TextCurve(OneLine):
    """A polygon that letters follow, parametrised by its length; they stand on its left.

    Parameters
    ----------
    points : (n, 2) float64
        In mm, x to the right and y up, in the direction of the text.
    is_closed : bool
        Whether the last point is joined to the first.

    Raises
    ------
    InputError
        If it has no length, or a point is not finite.
    """

    points: Float64
    is_closed: bool = False

    def __post_init__(self) -> None:
        points = np.array(self.points, np.float64)
        if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
            raise InputError(f"a curve for text must be finite points (n, 2); found {points.shape}")
        keep = np.ones(len(points), bool)
        keep[1:] = (np.diff(points, axis=0) != 0).any(axis=1)
        points = points[keep]
        if self.is_closed and len(points) > 1 and (points[0] == points[-1]).all():
            points = points[:-1]
        if len(points) < 2 + self.is_closed:
            raise InputError(f"a curve for text has {counted(len(points), 'point')}; expected at least two")
        object.__setattr__(self, "points", read_only(points))

    @cached_property
    def _nodes(self) -> tuple[Float64, Float64]:
        """Points, with the first again at the end of a closed curve, and the length up to each."""
        points = np.concatenate([self.points, self.points[:1]]) if self.is_closed else self.points
        return points, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])

    @property
    def length_mm(self) -> float:
        """Length of the curve."""
        return float(self._nodes[1][-1])

    def at(self, along_mm: Float64) -> Float64:
        """(..., 2) float64: points at lengths from the start; beyond the ends of an open curve, on its tangents."""
        points, lengths = self._nodes
        along = np.asarray(along_mm, np.float64)
        if self.is_closed:
            along = along % lengths[-1]
        index = np.clip(np.searchsorted(lengths, along, side="right") - 1, 0, len(lengths) - 2)
        part = (along - lengths[index]) / (lengths[index + 1] - lengths[index])
        return np.asarray(points[index] * (1 - part[..., None]) + points[index + 1] * part[..., None], np.float64)

    def directions(self, along_mm: Float64, width_mm: Float64 | float) -> Float64:
        """(..., 2) float64: unit vectors from half a width before places to half a width after them.

        A chord, not a tangent, so that letters turn evenly along polygons and around corners.
        """
        along = np.asarray(along_mm, np.float64)
        half = np.minimum(np.asarray(width_mm, np.float64), self.length_mm / 4) / 2
        chord = self.at(along + half) - self.at(along - half)
        lengths = np.hypot(chord[..., 0], chord[..., 1])[..., None]
        return np.asarray(chord / np.where(lengths > 0, lengths, 1.0), np.float64)

    def _line(self) -> str:
        kind = "closed" if self.is_closed else "open"
        return f"{kind}, {counted(len(self.points), 'point')}, {self.length_mm:.6g} mm"


def curve_around(ring: Float64, side: str = "top") -> tuple[TextCurve, float]:
    """A closed curve for text that can be read at the top or at the bottom, and the place of its middle.

    Parameters
    ----------
    ring : (n, 2) float64
        A closed polygon in mm, of either direction.
    side : str
        "top": clockwise, so that letters stand outwards; "bottom": counter-clockwise, so that they stand inwards.

    Returns
    -------
    curve : TextCurve
    middle_mm : float
        Length up to the outermost point on that side that lies midway between left and right.
    """
    clockwise = ring_area(ring) < 0
    points = ring if clockwise == (side == "top") else ring[::-1]
    curve = TextCurve(points, is_closed=True)
    nodes, lengths = curve._nodes
    middle = (nodes[:, 0].min() + nodes[:, 0].max()) / 2
    offset = nodes[:, 0] - middle
    crossing = np.flatnonzero((offset[:-1] <= 0) != (offset[1:] <= 0))
    part = offset[crossing] / (offset[crossing] - offset[crossing + 1])
    y = nodes[crossing, 1] * (1 - part) + nodes[crossing + 1, 1] * part
    best = int(np.argmax(y) if side == "top" else np.argmin(y))
    at = crossing[best]
    return curve, float(lengths[at] + part[best] * (lengths[at + 1] - lengths[at]))

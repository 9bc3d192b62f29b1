"""How often closed polygons wind around points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask

# points that are compared with all edges at once
_BAND = 256


def winding_on_grid(
    rings: Sequence[Float64], x: Float64, y: Float64, *, side: Literal["left", "right"] = "left"
) -> NDArray[np.int32]:
    """Winding numbers of closed polygons at the points of a grid.

    Parameters
    ----------
    rings : sequence of (n, 2) float64
    x : (cols,) float64
        Ascending.
    y : (rows,) float64
    side : str
        Whether a point on an edge counts as on its right ("left": the edge lies to the left of it) or on its left.

    Returns
    -------
    (rows, cols) int32
        Positive around rings that run clockwise where y points up.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]])
    >>> winding_on_grid([square], np.array([-1.0, 1.0, 3.0]), np.array([1.0])).tolist()
    [[0, 1, 0]]
    """
    order = np.argsort(y)
    levels = y[order]
    turns = np.zeros((len(y), len(x) + 1), np.int32)
    for start in rings:
        end = np.roll(start, -1, axis=0)
        low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
        first, last = np.searchsorted(levels, low, "left"), np.searchsorted(levels, high, "left")
        count = last - first
        edge = np.repeat(np.arange(len(start)), count)
        row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count - first, count)
        (x0, y0), (x1, y1) = start[edge].T, end[edge].T
        crossing = x0 + (levels[row] - y0) / (y1 - y0) * (x1 - x0)
        np.add.at(turns, (row, np.searchsorted(x, crossing, side)), np.where(y1 > y0, 1, -1))
    winding = np.empty((len(y), len(x)), np.int32)
    winding[order] = np.cumsum(turns[:, :-1], axis=1, dtype=np.int32)
    return winding


def winds_around(rings: Sequence[Float64], points: Float64) -> Mask:
    """(n,) bool: which of (n, 2) points closed polygons wind around."""
    turns = np.zeros(len(points), np.int64)
    for first in range(0, len(points), _BAND):
        x, y = points[first : first + _BAND].T[:, :, None]
        for start in rings:
            end = np.roll(start, -1, axis=0)
            crosses = (start[:, 1] <= y) != (end[:, 1] <= y)
            side = (end[:, 0] - start[:, 0]) * (y - start[:, 1]) - (end[:, 1] - start[:, 1]) * (x - start[:, 0])
            upward = end[:, 1] > start[:, 1]
            # edges to the right of the point
            counted = np.where(upward, 1, -1) * (crosses & ((side > 0) == upward))
            turns[first : first + _BAND] += counted.sum(axis=1)
    inside: Mask = turns != 0
    return inside

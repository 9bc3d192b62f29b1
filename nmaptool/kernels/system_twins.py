"""The system's operator on float64 heights, in NumPy: the twin of ``system.h``, for weights of any float type."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64

Weights = NDArray[np.floating[Any]]


def system_product(
    weight: Weights, beta: Weights, z: Float64, out: Float64, rows: int, cols: int, first: int, last: int
) -> float:
    """Write rows ``first`` to ``last`` of A z to ``out``, computed from differences of heights; returns 0.

    Parameters
    ----------
    weight : (H, W)
        Weight of each face.
    beta, z : (H+1, W+1)
    out : (last - first, W+1)
    rows, cols : int
        H + 1 and W + 1.
    first, last : int
    """
    count = (last - first) * cols
    heights = _heights(z, rows, first, last)
    half = _halves(weight, rows, cols, first, last)
    here = heights[cols:-cols]
    # along the rows: the flow over the left edge minus the flow over the right one
    flow = np.zeros(count + 1)
    np.subtract(heights[cols + 1 : count + cols + 1], here, out=flow[1:])
    flow[1:] *= half[:-cols] + half[cols:]
    across = flow[:-1] - flow[1:]
    # along the columns: the same, by faces
    steps = np.zeros(count + cols + 1)
    np.subtract(heights[cols:], heights[:-cols], out=steps[:-1])
    face_flow = np.zeros(count + cols + 1)
    np.add(steps[1:], steps[:-1], out=face_flow[1:])
    face_flow[1:] *= half
    both = face_flow[1:] + face_flow[:-1]
    down = both[:-cols] - both[cols:]
    down *= 0.5
    across += down
    across += np.multiply(beta[first:last].reshape(-1), here, out=down)
    out.reshape(-1)[:count] = across
    return 0.0


def _heights(z: Float64, rows: int, first: int, last: int) -> Float64:
    """Return the heights of a band and of one row above and below it, flat; rows outside the picture are 0."""
    if first > 0 and last < rows:
        return z[first - 1 : last + 1].reshape(-1)
    out = np.zeros((last - first + 2, z.shape[1]))
    above, below = max(first - 1, 0), min(last + 1, rows)
    out[above - first + 1 : below - first + 1] = z[above:below]
    return out.reshape(-1)


def _halves(weight: Weights, rows: int, cols: int, first: int, last: int) -> Float64:
    """Return half the weights of the faces above and below a band, flat, with a 0 at the end of each row."""
    out = np.zeros((last - first + 1, cols))
    above, below = max(first - 1, 0), min(last, rows - 1)
    np.multiply(weight[above:below], 0.5, out=out[above - first + 1 : below - first + 1, :-1])
    return out.reshape(-1)

"""Between the vertices of the picture and those of a coarse grid: bilinear interpolation, and its transpose."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.solver.tiling.grid import Box


def interpolation(part: slice, factor: int) -> tuple[Float64, int]:
    """Weights of the interpolation along one axis.

    Parameters
    ----------
    part : slice
        A range of vertices.
    factor : int
        Faces on the side of a coarse face.

    Returns
    -------
    weights : (n, m) float64
        Weight of each of the m coarse vertices for each of the n vertices.
    first : int
        Number of the first of these coarse vertices.
    """
    places = np.arange(part.start, part.stop)
    first, last = part.start // factor, (part.stop - 1) // factor + 1
    weights = np.zeros((len(places), last - first + 1))
    upper, share = places // factor - first, places % factor / factor
    rows = np.arange(len(places))
    weights[rows, upper] = 1 - share
    weights[rows, upper + 1] += share
    return weights, first


def coarse_box(box: Box, factor: int) -> Box:
    """The coarse vertices around a box of vertices."""
    rows, cols = (slice(part.start // factor, (part.stop - 1) // factor + 2) for part in box)
    return rows, cols


def restrict(values: Float64, box: Box, factor: int) -> Float64:
    """Sum the values of a box of vertices into the coarse vertices around it, by the weights of the interpolation.

    Returns
    -------
    float64
        Values of the coarse vertices in `coarse_box`.
    """
    return _restricted(_restricted(values, box[0], factor).T, box[1], factor).T


def _restricted(values: Float64, part: slice, factor: int) -> Float64:
    """The sums along the first axis; by blocks if the part begins at a coarse vertex."""
    whole = len(values) // factor
    first, last = part.start // factor, (part.stop - 1) // factor + 1
    out = np.zeros((last - first + 1, values.shape[1]))
    done = 0
    if part.start % factor == 0 and whole:
        done = whole * factor
        blocks = values[:done].reshape(whole, factor, values.shape[1])
        for row in range(factor):
            share = row / factor
            out[:whole] += (1 - share) * blocks[:, row]
            if row:
                out[1 : whole + 1] += share * blocks[:, row]
    if done < len(values):
        rest = slice(part.start + done, part.stop)
        weights, start = interpolation(rest, factor)
        out[start - first : start - first + weights.shape[1]] += weights.T @ values[done:]
    return out


def prolong(coarse: Float64, box: Box, factor: int) -> Float64:
    """Interpolate coarse vertices at a box of vertices.

    Parameters
    ----------
    coarse : float64
        Values of the coarse vertices in `coarse_box`.
    box : pair of slices
    factor : int
    """
    out: Float64 = _interpolated(_interpolated(coarse, box[0], factor).T, box[1], factor).T
    return np.ascontiguousarray(out)


def _interpolated(coarse: Float64, part: slice, factor: int) -> Float64:
    places = np.arange(part.start, part.stop)
    upper, share = places // factor - part.start // factor, (places % factor / factor)[:, None]
    out: Float64 = coarse[upper]
    step = np.diff(coarse, axis=0)[upper]
    step *= share
    out += step
    return out

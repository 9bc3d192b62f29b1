"""Resample heights smoothly: a larger picture of a small relief has no visible pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64

_POLE = np.sqrt(3.0) - 2.0
# taps of the recursion's start; the pole to this power is far below float32
_START = 16
# samples by which a surface is continued beyond its edges
_BEYOND = 8


def resampled(values: Float32, rows: Float64, cols: Float64) -> Float32:
    """Values of a cubic spline through samples, with continuous curvature.

    Parameters
    ----------
    values : (h, w) float32
    rows : (m,) float64
        Places in rows of ``values``; those outside read the edge.
    cols : (n,) float64

    Returns
    -------
    (m, n) float32

    Examples
    --------
    >>> resampled(np.float32([[0, 1, 2]]), np.zeros(1), np.array([0.0, 0.5, 1.25])).round(3).tolist()
    [[0.0, 0.5, 1.25]]
    """
    return _along_rows(_along_rows(values, rows).T, cols).T


def _along_rows(values: Float32, places: Float64) -> Float32:
    count = len(values)
    places = places.clip(0, count - 1)
    if count == 1:
        return np.repeat(values, len(places), axis=0)
    if np.array_equal(places, np.round(places)):
        return values[places.astype(np.intp)]
    # continued with their slope, so that a plane stays one up to its edge
    spline = _coefficients(np.pad(values, ((_BEYOND, _BEYOND), (0, 0)), mode="reflect", reflect_type="odd"))
    places, count = places + _BEYOND, count + 2 * _BEYOND
    first = np.minimum(places.astype(np.intp), count - 2)
    t = (places - first).astype(np.float32)
    weights = ((1 - t) ** 3 / 6, (3 * t**3 - 6 * t**2 + 4) / 6, (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6, t**3 / 6)
    out = np.zeros((len(places), values.shape[1]), np.float32)
    for step, weight in enumerate(weights, start=-1):
        out += weight[:, None] * spline[_mirrored(first + step, count)]
    return out


def _mirrored(index: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    index = np.abs(index) % (2 * count - 2)
    return np.where(index >= count, 2 * (count - 1) - index, index)


def _coefficients(values: Float32) -> Float32:
    """Coefficients of the spline along the first axis, mirrored at both ends."""
    c = 6 * values
    count = len(c)
    near = c[_mirrored(np.arange(_START), count)]
    c[0] = np.tensordot((_POLE ** np.arange(len(near))).astype(np.float32), near, 1)
    pole = np.float32(_POLE)
    for row in range(1, count):
        c[row] += pole * c[row - 1]
    c[-1] = pole / (pole * pole - 1) * (c[-1] + pole * c[-2])
    for row in range(count - 2, -1, -1):
        c[row] = pole * (c[row + 1] - c[row])
    return c

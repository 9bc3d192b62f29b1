"""Bezier curves as polygons that stay within a tolerance of them."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float64

_MOST_PIECES = 4096


def flatten_bezier(controls: Float64, tolerance: float) -> Float64:
    """Points on a Bezier curve, whose polygon is nowhere further from the curve than a tolerance.

    Parameters
    ----------
    controls : (2, 2), (3, 2) or (4, 2) float64
        Control points of a line, a quadratic or a cubic curve.
    tolerance : float
        In the unit of the points.

    Returns
    -------
    (n, 2) float64
        Points at equal steps of the parameter, without the first control point, with the last.

    Examples
    --------
    >>> flatten_bezier(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.1)
    array([[0.75, 0.25],
           [1.  , 1.  ]])
    """
    degree = len(controls) - 1
    if degree == 1:
        return controls[1:]
    # Wang's bound: the second difference of the controls limits the second derivative
    bend = float(np.hypot(*(controls[:-2] - 2 * controls[1:-1] + controls[2:]).T).max())
    pieces = math.ceil(math.sqrt(degree * (degree - 1) / 8 * bend / tolerance)) if bend > 0 else 1
    t = np.linspace(0.0, 1.0, min(max(pieces, 1), _MOST_PIECES) + 1)[1:, None]
    points = controls[None, :, :].repeat(len(t), axis=0)
    while points.shape[1] > 1:  # de Casteljau, which ends exactly on the last control point
        points = points[:, :-1] * (1 - t[:, None]) + points[:, 1:] * t[:, None]
    return np.asarray(points[:, 0], np.float64)

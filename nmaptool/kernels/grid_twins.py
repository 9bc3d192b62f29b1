"""Smoothing and residuals on the coarse levels of the multigrid solver, in NumPy: the twins of ``grid.h``.

For any float type. Fields are flat; those "with margins" hold cols + 1 more numbers before the first and after the last
vertex. ``start`` and ``stop`` count vertices.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.floating[Any]]


def accumulate(one: Values, other: Values, out: Values) -> None:
    """Add a product to ``out`` in one pass; all arrays are flat, contiguous and of the same type."""
    cv2.accumulateProduct(one, other, out)


def add_product(out: Values, one: Values, *others: Values) -> None:
    """Add a product to ``out``, in one pass for two factors; all arrays are flat, contiguous and of the same type."""
    for other in others[1:]:
        one = one * other
    accumulate(one, others[0], out)


def _add_neighbours(
    couplings: tuple[Values, Values, Values, Values], x: Values, out: Values, cols: int, start: int, stop: int
) -> None:
    """Add the sum of coupling times x over the eight neighbours to ``out``, which begins at ``start``."""
    first, last = cols + 1 + start, cols + 1 + stop
    for values, step in zip(couplings, (1, cols, cols + 1, cols - 1), strict=True):
        accumulate(values[first:last], x[first + step : last + step], out)
        accumulate(values[first - step : last - step], x[first - step : last - step], out)


def coarse_step(
    e: Values,
    s: Values,
    se: Values,
    sw: Values,
    x: Values,
    out: Values,
    load: Values,
    inverse: Values,
    cols: int,
    start: int,
    stop: int,
    length: float,
) -> float:
    """Write x + length D^-1 (load - A x) to ``out``; returns 0.

    Parameters
    ----------
    e, s, se, sw, x, out : flat with margins
        Couplings to the east, south, south-east and south-west; the correction.
    load, inverse : flat
        Right-hand side; 1 over the diagonal.
    cols, start, stop : int
    length : float
    """
    first, last = cols + 1 + start, cols + 1 + stop
    pull = load[start:stop].copy()
    _add_neighbours((e, s, se, sw), x, pull, cols, start, stop)
    pull *= length
    np.multiply(x[first:last], 1 - length, out=out[first:last])
    accumulate(pull, inverse[start:stop], out[first:last])
    return 0.0


def coarse_left(
    e: Values,
    s: Values,
    se: Values,
    sw: Values,
    x: Values,
    load: Values,
    diagonal: Values,
    out: Values,
    cols: int,
    start: int,
    stop: int,
) -> float:
    """Write load - A x to ``out``; returns 0.

    Parameters
    ----------
    e, s, se, sw, x : flat with margins
    load, diagonal, out : flat
    cols, start, stop : int
    """
    own = out[start:stop]
    np.multiply(diagonal[start:stop], x[cols + 1 + start : cols + 1 + stop], out=own)
    np.subtract(load[start:stop], own, out=own)
    _add_neighbours((e, s, se, sw), x, own, cols, start, stop)
    return 0.0

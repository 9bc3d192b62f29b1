"""Smoothing and products on the levels of the multigrid solver, in NumPy: the twins of ``grid.h``, for any float type.

Fields are flat; those "with margins" hold cols + 1 more numbers before the first and after the last vertex. A face is
stored at its upper left vertex. ``start`` and ``stop`` count vertices.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.floating[Any]]


def finest_product(
    quarter: Values,
    x: Values,
    beta: Values,
    unknown: NDArray[np.bool_],
    out: Values,
    cols: int,
    start: int,
    stop: int,
    holds: bool,
) -> float:
    """Write A x to ``out``, computed from differences of x, and return the inner product of x and A x.

    Parameters
    ----------
    quarter, x : flat with margins
        A quarter of the weight of each face; heights.
    beta, unknown, out : flat
    cols, start, stop : int
    holds : bool
        Whether A x is 0 where a vertex is not unknown.
    """
    edge, inside = cols + 1, stop - start
    first = edge + start - cols - 1
    around = quarter[first : first + inside + cols + 1]
    # along rows: the edges left and right of each vertex, weighted by the faces above and below them
    across = x[edge + start : edge + stop + 1] - x[edge + start - 1 : edge + stop]
    across *= around[: inside + 1] + around[cols:]
    own = across[:-1] - across[1:]
    own *= 2
    # between rows: the faces above and below
    drop = x[edge + start - 1 : edge + stop + cols + 1] - x[first : edge + stop + 1]
    along = drop[: inside + cols + 1] + drop[1:]
    along *= around
    pair = np.add(along[:-1], along[1:], out=drop[: inside + cols])
    own += pair[:inside]
    own -= pair[cols:]
    own += beta[start:stop] * x[edge + start : edge + stop]
    if holds:
        own *= unknown[start:stop]
    out[start:stop] = own
    return float((x[edge + start : edge + stop] * out[start:stop]).sum())


def _mixed(quarter: Values, x: Values, cols: int, start: int, stop: int) -> Values:
    """Return the pull of the means of the faces, corner_sum(weight * corner_mean(x)), for a range of vertices."""
    first, count = start, stop - start + cols + 1  # faces
    pair = x[first : first + count + cols] + x[first + 1 : first + count + cols + 1]
    sums = pair[:count] + pair[cols:]
    sums *= quarter[first : first + count]
    np.add(sums[:-1], sums[1:], out=pair[: count - 1])
    return np.asarray(pair[: stop - start] + pair[cols : cols + stop - start])


def finest_left(
    quarter: Values, z: Values, residual: Values, out: Values, cols: int, start: int, stop: int, share: float
) -> float:
    """Write the residual after the first smoothing step, from zero, to ``out``, which begins at ``start``; returns 0.

    Parameters
    ----------
    quarter, z : flat with margins
    residual : flat
    out : (stop - start,)
    cols, start, stop : int
    share : float
        1 minus the length of the step in units of the inverse of the weights around a vertex.
    """
    np.add(_mixed(quarter, z, cols, start, stop), residual[start:stop] * share, out=out)
    return 0.0


def finest_finish(
    quarter: Values,
    z: Values,
    residual: Values,
    step: Values,
    out: Values,
    cols: int,
    start: int,
    stop: int,
    share: float,
) -> float:
    """Write the last smoothing step from z to ``out``; return the inner product of out and residual.

    Parameters
    ----------
    quarter, z : flat with margins
    residual, step, out : flat
        ``step`` is the length of a smoothing step at each vertex.
    cols, start, stop : int
    share : float
        As in `finest_left`.
    """
    moved = _mixed(quarter, z, cols, start, stop)
    moved += residual[start:stop]
    moved *= step[start:stop]
    np.multiply(z[cols + 1 + start : cols + 1 + stop], share, out=out[start:stop])
    out[start:stop] += moved
    return float((out[start:stop] * residual[start:stop]).sum())


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

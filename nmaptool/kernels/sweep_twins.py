"""Sweeps over the finest level of the multigrid solver, in NumPy: the twins of ``sweeps.h`` and ``directions.h``.

For any float type. Fields are flat; those "with margins" hold cols + 1 more numbers before the first and after the last
vertex. A face is stored at its upper left vertex. A smoothing step of the finest level is Jacobi's, with ``share`` = 1
minus its length in units of the inverse of the weights around a vertex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.kernels.grid_twins import Values
from nmaptool.kernels.transfer_twins import prolong_rows, restrict_rows


def _mixed(quarter: Values, x: Values, cols: int, start: int, stop: int) -> Values:
    """Return the pull of the means of the faces, corner_sum(weight * corner_mean(x)), for a range of vertices."""
    first, count = start, stop - start + cols + 1  # faces
    pair = x[first : first + count + cols] + x[first + 1 : first + count + cols + 1]
    sums = pair[:count] + pair[cols:]
    sums *= quarter[first : first + count]
    np.add(sums[:-1], sums[1:], out=pair[: count - 1])
    return np.asarray(pair[: stop - start] + pair[cols : cols + stop - start])


def _rows_of(values: Values, cols: int, first: int, last: int) -> Values:
    """Return a view of some rows of a field with margins, with margins."""
    return values[first * cols : last * cols + 2 * (cols + 1)]


def finest_descend(
    finest: tuple[Values, Values, Values],
    weights: tuple[Values, ...],
    results: tuple[Values],
    rows: int,
    cols: int,
    first: int,
    last: int,
    share: float,
) -> float:
    """Restrict the residual that is left after one smoothing step from zero; returns 0.

    Parameters
    ----------
    finest : tuple
        A quarter of the weight of each face (with margins), the length of a step at each vertex, and the residual.
    weights : tuple of 8 flat arrays with margins
        As for `nmaptool.kernels.transfer_twins.restrict_rows`.
    results : tuple of a flat array
        The coarse residual, of which rows ``first`` to ``last`` are written.
    rows, cols : int
        Vertices of the finest level.
    first, last : int
    share : float
    """
    quarter, step, residual = finest
    above, below = max(2 * first - 1, 0), min(2 * last, rows)
    top, bottom = max(above - 1, 0), min(below + 1, rows)
    z = np.zeros((below - above) * cols + 2 * (cols + 1), residual.dtype)
    at, known = (top - above) * cols + cols + 1, slice(top * cols, bottom * cols)
    np.multiply(residual[known], step[known], out=z[at : at + (bottom - top) * cols])
    left = _mixed(_rows_of(quarter, cols, above, below), z, cols, 0, (below - above) * cols)
    left += residual[above * cols : below * cols] * share
    b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se = weights
    ends = cols, (cols + 1) // 2, above - 2 * first, first, last
    restrict_rows(b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se, left, results[0], *ends)
    return 0.0


def finest_ascend(
    finest: tuple[Values, Values, Values, Values],
    weights: tuple[Values, ...],
    results: tuple[Values],
    rows: int,
    cols: int,
    first: int,
    last: int,
    share: float,
) -> float:
    """Add the coarse correction to one smoothing step from zero, do another; return its product with the residual.

    Parameters
    ----------
    finest : tuple
        As for `finest_descend`, and the coarse correction (with margins).
    weights : tuple of 8 flat arrays with margins
    results : tuple of a flat array
        The correction; written at the rows of the vertices in rows ``first`` to ``last`` of the coarse level.
    rows, cols, first, last : int
    share : float
    """
    (quarter, step, residual, coarse), (out,) = finest, results
    coarse_rows, coarse_cols = (rows + 1) // 2, (cols + 1) // 2
    low, high = max(first - 1, 0), min(last + 1, coarse_rows)
    top, bottom = 2 * low, min(2 * high, rows)
    known = slice(top * cols, bottom * cols)
    z = np.zeros((bottom - top) * cols + 2 * (cols + 1), residual.dtype)
    np.multiply(residual[known], step[known], out=z[cols + 1 : cols + 1 + (bottom - top) * cols])
    b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se = (_rows_of(each, coarse_cols, low, high) for each in weights)
    near, ends = _rows_of(coarse, coarse_cols, low, high), (cols, coarse_cols, bottom - top, 0, high - low)
    prolong_rows(b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se, near, z, *ends)
    start, stop = 2 * first * cols, min(2 * last, rows) * cols
    begin, end = start - top * cols, stop - top * cols
    moved = _mixed(_rows_of(quarter, cols, top, bottom), z, cols, begin, end)
    moved += residual[start:stop]
    moved *= step[start:stop]
    np.multiply(z[cols + 1 + begin : cols + 1 + end], share, out=out[start:stop])
    out[start:stop] += moved
    return float((out[start:stop] * residual[start:stop]).sum())


def finest_advance(
    finest: tuple[Values, Values, NDArray[np.bool_], Values, Values],
    results: tuple[Values, Values],
    rows: int,
    cols: int,
    first: int,
    last: int,
    turn: float,
    holds: bool,
) -> float:
    """Turn the direction of conjugate gradients, multiply it by A, and return the product of both.

    Parameters
    ----------
    finest : tuple
        A quarter of the weight of each face (with margins); beta and whether a vertex is unknown (flat); and the new
        direction in the row above ``first`` and in row ``last``, (cols + 1,), of which cols count.
    results : tuple
        The direction (with margins), which becomes ``turn`` times itself plus ``other``, and ``other``, which becomes A
        times the direction.
    rows, cols, first, last : int
    turn : float
    holds : bool
        Whether A x is 0 where a vertex is not unknown.
    """
    (quarter, beta, unknown, above, below), (direction, other) = finest, results
    start, stop, edge = first * cols, last * cols, cols + 1
    own = direction[edge + start : edge + stop]
    own *= turn
    own += other[start:stop]
    x = _rows_of(direction, cols, first, last).copy()
    x[1:edge] = above[:cols] if first > 0 else 0
    x[edge + stop - start : -1] = below[:cols] if last < rows else 0
    other[start:stop] = _product(_rows_of(quarter, cols, first, last), x, cols, stop - start)
    other[start:stop] += beta[start:stop] * own
    if holds:
        other[start:stop] *= unknown[start:stop]
    return float((own * other[start:stop]).sum())


def _product(quarter: Values, x: Values, cols: int, count: int) -> Values:
    """Return A x without beta, from differences of x; both arguments are with margins."""
    around = quarter[: count + cols + 1]
    # along rows: the edges left and right of each vertex, weighted by the faces above and below them
    across = x[cols + 1 : cols + 2 + count] - x[cols : cols + 1 + count]
    across *= around[: count + 1] + around[cols:]
    own = across[:-1] - across[1:]
    own *= 2
    # between rows: the faces above and below
    drop = x[cols:] - x[: count + cols + 2]
    along = drop[:-1] + drop[1:]
    along *= around
    pair = along[:-1] + along[1:]
    own += pair[:count]
    own -= pair[cols:]
    return np.asarray(own)

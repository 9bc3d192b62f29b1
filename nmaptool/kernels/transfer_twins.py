"""Transfer between the levels of the multigrid solver, and the steps of conjugate gradients, in NumPy.

The twins of ``transfer.h``, for any float type. Weights are in the layout of the coarse grid, flat with margins of
cols + 1 numbers: how much of a coarse vertex a fine neighbour takes, in the order of `nmaptool.solver.multigrid`:
b_w, b_e (beside), u_n, u_s (under), d_nw, d_ne, d_sw, d_se (diagonal).
"""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.kernels.grid_twins import Values, accumulate


def restrict_rows(
    b_w: Values,
    b_e: Values,
    u_n: Values,
    u_s: Values,
    d_nw: Values,
    d_ne: Values,
    d_sw: Values,
    d_se: Values,
    fine: Values,
    out: Values,
    fine_cols: int,
    cols: int,
    top: int,
    first: int,
    last: int,
) -> float:
    """Write coarse rows ``first`` to ``last`` of a residual to ``out``; returns 0.

    Parameters
    ----------
    b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se : flat with margins
    fine : flat
        Fine rows from row 2 * first + top, to row 2 * last or the end.
    out : flat
        The whole coarse residual.
    fine_cols, cols : int
    top : int
        0 or -1.
    first, last : int
    """
    rows = fine.reshape(-1, fine_cols)
    start, stop = cols + 1 + first * cols, cols + 1 + last * cols
    lead = -top

    def part(down: int, across: int) -> Values:
        """Return the rows of a kind, flat, after one zero; kinds below start one row higher."""
        kind = np.zeros(1 + (down + last - first) * cols, fine.dtype)
        skip = down * (1 - lead)
        found = rows[(1 - lead if down else lead) :: 2, across::2][: down + last - first - skip]
        kind[1:].reshape(-1, cols)[skip : skip + found.shape[0], : found.shape[1]] = found
        return kind

    beside, under, diagonal = part(0, 1), part(1, 0), part(1, 1)
    own = rows[lead::2, ::2][: last - first].ravel()
    for weight, step, values in (
        (b_w, 0, beside[1:]),
        (b_e, 1, beside[:-1]),
        (u_n, 0, under[1 + cols :]),
        (u_s, cols, under[1:-cols]),
        (d_nw, 0, diagonal[1 + cols :]),
        (d_ne, 1, diagonal[cols:-1]),
        (d_sw, cols, diagonal[1:-cols]),
        (d_se, cols + 1, diagonal[: -cols - 1]),
    ):
        accumulate(weight[start - step : stop - step], values, own)
    out[first * cols : last * cols] = own
    return 0.0


def prolong_rows(
    b_w: Values,
    b_e: Values,
    u_n: Values,
    u_s: Values,
    d_nw: Values,
    d_ne: Values,
    d_sw: Values,
    d_se: Values,
    coarse: Values,
    fine: Values,
    fine_cols: int,
    cols: int,
    fine_rows: int,
    first: int,
    last: int,
) -> float:
    """Add the interpolation of coarse rows ``first`` to ``last`` to ``fine``; returns 0.

    Parameters
    ----------
    b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se, coarse, fine : flat with margins
    fine_cols, cols, fine_rows, first, last : int
    """
    grid = fine[fine_cols + 1 : fine_cols + 1 + fine_rows * fine_cols].reshape(fine_rows, fine_cols)
    start, stop = cols + 1 + first * cols, cols + 1 + last * cols

    def add(down: int, across: int, *parts: tuple[Values, int]) -> None:
        where = grid[2 * first + down : 2 * last : 2, across::2]
        total = parts[0][0][start:stop] * coarse[start + parts[0][1] : stop + parts[0][1]]
        for weight, step in parts[1:]:
            accumulate(weight[start:stop], coarse[start + step : stop + step], total)
        where += total.reshape(-1, cols)[: where.shape[0], : where.shape[1]]

    grid[2 * first : 2 * last : 2, ::2] += coarse[start:stop].reshape(-1, cols)
    add(0, 1, (b_w, 0), (b_e, 1))
    add(1, 0, (u_n, 0), (u_s, cols))
    add(1, 1, (d_nw, 0), (d_ne, 1), (d_sw, cols), (d_se, cols + 1))
    return 0.0


def move(
    direction: Values,
    product: Values,
    z: Float64,
    left: Values,
    length: float,
    size: float,
    start: int,
    stop: int,
    margin: int,
) -> float:
    """Move heights along a direction, and the residual with them; return the squared norm of the new residual.

    Parameters
    ----------
    direction : flat with margins
    product : flat
        A times the direction.
    z : flat float64
        Heights. ``length`` times ``size`` times the direction is added in float64: with a step rounded to float32, the
        heights would no longer match the residual.
    left : flat
        The residual; ``length`` times the product is subtracted.
    length, size : float
    start, stop, margin : int
    """
    z[start:stop] += np.multiply(direction[margin + start : margin + stop], length * size, dtype=np.float64)
    own = left[start:stop]
    own -= np.multiply(product[start:stop], length, dtype=own.dtype)
    return float((own * own).sum())

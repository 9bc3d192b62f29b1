"""Sparse matrices by rows, in NumPy: the twins of ``rows.h``, for any float type.

The entries of row i are at ``start[i]`` to ``start[i + 1]``; their columns and values are in two arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.kernels.grid_twins import Values

Indices = NDArray[np.int64]


def sort_rows(row: Indices, column: Indices, value: Values, start: Indices, columns: Indices, values: Values) -> float:
    """Sort entries by row, in their order within a row; returns 0.

    Parameters
    ----------
    row, column, value : (n,)
    start : (rows + 1,) int64
    columns, values : (n,)
        Results, as is ``start``.
    """
    order = np.argsort(row, kind="stable")
    start[0] = 0
    np.cumsum(np.bincount(row, minlength=len(start) - 1), out=start[1:])
    columns[:], values[:] = column[order], value[order]
    return 0.0


def rows_times(start: Indices, column: Indices, value: Values, x: Values, out: Values) -> float:
    """Write the product of a matrix and ``x`` to ``out``; returns 0.

    Parameters
    ----------
    start : (rows + 1,) int64
    column, value : (n,)
    x : (columns,)
    out : (rows,)
    """
    row = np.repeat(np.arange(len(out)), np.diff(start))
    out[:] = np.bincount(row, value * x[column], minlength=len(out))
    return 0.0


def rows_product(
    start: Indices,
    column: Indices,
    value: Values,
    second_start: Indices,
    second_column: Indices,
    second_value: Values,
    count: int,
    out_start: Indices,
    columns: Indices,
    values: Values,
) -> float:
    """Write the product of two matrices; return the number of its entries.

    Parameters
    ----------
    start, column, value
        The first matrix.
    second_start, second_column, second_value
        The second one.
    count : int
        Columns of the second matrix.
    out_start : (rows + 1,) int64
    columns, values : (n,)
        Room for one entry for each pair of entries; each place has one entry in the end, in any order of the columns.
    """
    lengths = np.diff(second_start)[column]
    pair = np.repeat(np.arange(len(column)), lengths)
    at = np.arange(len(pair)) + np.repeat(second_start[column] - (np.cumsum(lengths) - lengths), lengths)
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))[pair]
    places, place = np.unique(row * max(count, 1) + second_column[at], return_inverse=True)
    sums = np.bincount(place, value[pair] * second_value[at], minlength=len(places))
    found = len(places)
    columns[:found], values[:found] = places % max(count, 1), sums
    out_start[0] = 0
    np.cumsum(np.bincount(places // max(count, 1), minlength=len(start) - 1), out=out_start[1:])
    return float(found)

"""A small symmetric system by its Cholesky factor, in NumPy and SciPy: the twins of ``profile.h``.

Row i of the factor is stored from column ``first[i]`` to the diagonal, at ``offset[i]`` to ``offset[i + 1]`` of the
values.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.kernels.row_twins import Indices


def order_graph(start: Indices, column: Indices, order: Indices, part: Indices) -> float:
    """Order the vertices of a graph by part, each part in an order of short rows; return the number of parts.

    Parameters
    ----------
    start : (n + 1,) int64
    column : (links,) int64
        Neighbours of each vertex.
    order : (n,) int64
        Result: the vertices by part, each in reverse Cuthill-McKee order.
    part : (n,) int64
        Result: the part of each vertex.
    """
    from scipy import sparse  # takes long to load

    count = len(start) - 1
    if count == 0:
        return 0.0
    graph = sparse.csr_matrix((np.ones(len(column), np.int8), column, start), shape=(count, count))
    parts, found = sparse.csgraph.connected_components(graph, directed=False)
    part[:] = found
    by_rows = sparse.csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True)
    order[:] = by_rows[np.argsort(found[by_rows], kind="stable")]
    return float(parts)


def profile_factor(first: Indices, offset: Indices, values: Float64) -> float:
    """Replace a matrix by its Cholesky factor; return the least pivot, or one that is not positive, where it ends.

    Parameters
    ----------
    first : (n,) int64
    offset : (n + 1,) int64
    values : (entries,) float64
    """
    rows = [values[begin:end] for begin, end in pairwise(offset)]
    least = 1e300
    for i, row in enumerate(rows):
        own = int(first[i])
        for j in range(own, i):
            begin = max(own, int(first[j]))
            done = row[begin - own : j - own] @ rows[j][begin - int(first[j]) : -1]
            row[j - own] = (row[j - own] - done) / rows[j][-1]
        pivot = float(row[-1] - row[:-1] @ row[:-1])
        if not pivot > 0:
            return min(pivot, 0.0)
        least = min(least, pivot)
        row[-1] = np.sqrt(pivot)
    return least


def profile_solve(first: Indices, offset: Indices, values: Float64, x: Float64) -> float:
    """Replace a right-hand side by the solution; returns 0.

    Parameters
    ----------
    first : (n,) int64
    offset : (n + 1,) int64
    values : (entries,) float64
        The Cholesky factor.
    x : (n,) float64
    """
    rows = [values[begin:end] for begin, end in pairwise(offset)]
    for i, row in enumerate(rows):
        x[i] = (x[i] - row[:-1] @ x[first[i] : i]) / row[-1]
    for i, row in reversed(list(enumerate(rows))):
        x[i] /= row[-1]
        x[first[i] : i] -= x[i] * row[:-1]
    return 0.0

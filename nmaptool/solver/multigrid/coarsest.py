"""The coarsest level, where masks have become irregular: an assembled matrix and its factor or pyamg hierarchy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.core.arrays import Float64
from nmaptool.kernels.grid_twins import Values
from nmaptool.kernels.row_twins import sort_rows
from nmaptool.solver.multigrid.level import Stencil, inner

if TYPE_CHECKING:
    from scipy import sparse

# up to this number of products, our own factor is at least as fast as a sparse LU, which takes long to load
_FEW_PRODUCTS = 2e7
# up to this many unknowns a sparse LU is faster than a hierarchy: thin shapes leave a graph that is almost a tree
_DIRECT = 60_000
# ties below this share of a part's couplings are lost in rounding
_NO_TIE = 1e-11

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Coarsest:
    """The system of the coarsest level.

    Attributes
    ----------
    start, column, value
        Couplings by rows, float64: those of unknown i are at ``start[i]`` to ``start[i + 1]``.
    diagonal : (n,) float64
        One unknown is tied in each part without ties.
    order : (n,) int64
        The unknowns by part, in an order of short rows.
    places : (n,) int64
        Their indices in the level; grid first, then off-grid.
    part : (n,) int64
        The part, connected by couplings, of each unknown.
    size : (parts,) int64
        Unknowns of each part without ties, 0 for the others.
    """

    start: Indices
    column: Indices
    value: Float64
    diagonal: Float64
    order: Indices
    places: Indices
    part: Indices
    size: Indices

    def balanced(self, values: Float64) -> Float64:
        """Subtract the mean of each part without ties: no heights can change that of a load, and none matters.

        Rounding on the finer levels makes it grow otherwise.
        """
        if not self.size.any():
            return values
        total = np.bincount(self.part, values, minlength=len(self.size))
        mean = np.divide(total, self.size, out=np.zeros(len(self.size)), where=self.size > 0)
        return values - mean[self.part]

    @property
    def row(self) -> Indices:
        """The row of each coupling."""
        return np.repeat(np.arange(len(self.places)), np.diff(self.start))

    def matrix(self) -> sparse.csr_matrix:
        """Return the matrix in CSR, float64."""
        from scipy import sparse  # takes long to load

        count = len(self.places)
        couplings = sparse.csr_matrix((self.value, self.column, self.start), shape=(count, count))
        return (sparse.diags(self.diagonal) - couplings).tocsr()


def assemble(level: Stencil) -> Coarsest:
    """Return the system of a level; its diagonal is summed in float64."""
    active = np.concatenate([level.diagonal > 0, level.off_grid.diagonal > 0])
    number = np.cumsum(active) - 1
    count = int(active.sum())
    ends = _couplings(level)
    one, two = (number[np.concatenate([end[i] for end in ends])] for i in (0, 1))
    value = np.concatenate([end[2] for end in ends]).astype(np.float64)
    row, column, both = np.concatenate([one, two]), np.concatenate([two, one]), np.concatenate([value, value])
    total = np.bincount(row, both, minlength=count)
    start, columns, values = np.empty(count + 1, np.int64), np.empty_like(column), np.empty_like(both)
    sort_rows(row, column, both, start, columns, values)
    order, part = np.empty(count, np.int64), np.empty(count, np.int64)
    parts = int(kernels.order_graph(start, columns, order, part))
    tie = np.concatenate([inner(level.tie, level.shape).ravel(), level.off_grid.tie])[active].astype(np.float64)
    ties, sums = (np.bincount(part, each, minlength=parts) for each in (tie, total))
    loose = ties <= _NO_TIE * sums
    diagonal = total + tie
    if loose.any():
        # the constant is free there, so any will do
        _, first = np.unique(part, return_index=True)
        tied = first[loose]
        diagonal[tied] += np.maximum(total[tied], 1e-300)
    unknowns = np.where(loose, np.bincount(part, minlength=parts), 0)
    return Coarsest(start, columns, values, diagonal, order, np.flatnonzero(active), part, unknowns)


def _couplings(level: Stencil) -> list[tuple[Indices, Indices, Values]]:
    """Return each coupling of a level once, as arrays of its two ends and its value."""
    rows, cols = level.shape
    size, off_grid = level.size, level.off_grid
    place = np.arange(size).reshape(rows, cols)
    ends: list[tuple[Indices, Indices, Values]] = []
    for name, down, across in (("e", 0, 1), ("s", 1, 0), ("se", 1, 1), ("sw", 1, -1)):
        values = inner(level.couplings[name], level.shape)
        here = place[: rows - down, max(-across, 0) : cols - max(across, 0)].ravel()
        found = here[values.ravel()[here] != 0]
        ends.append((found, found + down * cols + across, values.ravel()[found]))
    near, among = off_grid.to_grid, off_grid.among
    once = among.row < among.column
    ends.append((off_grid.near[near.row], size + near.column, near.value))
    ends.append((size + among.row[once], size + among.column[once], among.value[once]))
    return ends


def coarse_solver(coarsest: Coarsest) -> Callable[[Float64], Float64]:
    """Return an approximate inverse, symmetric and positive: by a factor, or two Ruge-Stueben cycles if it is large."""
    count = len(coarsest.places)
    if count == 0:
        return lambda b: b
    position = np.empty(count, np.int64)
    position[coarsest.order] = np.arange(count)
    row, column = position[coarsest.row], position[coarsest.column]
    first = np.arange(count)
    np.minimum.at(first, row, column)
    if float((np.square(np.arange(count) - first)).sum()) <= _FEW_PRODUCTS:
        solve = _factored(coarsest, first, row, column)
        if solve is not None:
            return solve
    if count <= _DIRECT:
        from scipy.sparse.linalg import splu

        of_lu: Callable[[Float64], Float64] = splu(
            coarsest.matrix().tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        ).solve
        return of_lu
    return _two_cycles(coarsest.matrix())


def _factored(coarsest: Coarsest, first: Indices, row: Indices, column: Indices) -> Callable[[Float64], Float64] | None:
    """Return the inverse by a Cholesky factor; None if rounding errors make a pivot 0.

    ``first`` is the first column of each row in the order of the unknowns, ``row`` and ``column`` the couplings'.
    """
    offset = np.concatenate([[0], np.cumsum(np.arange(len(first)) - first + 1)])
    values = np.zeros(offset[-1])
    values[offset[1:] - 1] = coarsest.diagonal[coarsest.order]
    below = column < row
    values[offset[row[below]] + column[below] - first[row[below]]] = -coarsest.value[below]
    if not kernels.profile_factor(first, offset, values) > 0:
        return None

    def solve(b: Float64) -> Float64:
        x = b[coarsest.order]
        kernels.profile_solve(first, offset, values, x)
        out = np.empty_like(x)
        out[coarsest.order] = x
        return out

    return solve


def _two_cycles(matrix: sparse.csr_matrix) -> Callable[[Float64], Float64]:
    from nmaptool.solver.amg_hierarchy import hierarchy_of

    cycle = hierarchy_of(matrix).aspreconditioner(cycle="V")

    def twice(b: Float64) -> Float64:
        x: Float64 = cycle @ b
        x += cycle @ (b - matrix @ x)
        return x

    return twice

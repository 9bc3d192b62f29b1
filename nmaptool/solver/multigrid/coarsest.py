"""The coarsest level, where masks have become irregular: an assembled matrix and its LU or pyamg hierarchy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from nmaptool.core.arrays import Float64
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.amg_hierarchy import hierarchy_of
from nmaptool.solver.multigrid.level import Stencil, inner

# up to this many unknowns a sparse LU is faster than a hierarchy: thin shapes leave a graph that is almost a tree
_DIRECT = 60_000
# ties below this share of a part's couplings are lost in rounding
_NO_TIE = 1e-11


@dataclass(frozen=True, eq=False)
class Coarsest:
    """The system of the coarsest level.

    Attributes
    ----------
    matrix : CSR float64
        Of the active unknowns; one unknown is tied in each part without ties.
    places : (n,) int64
        Their indices in the level; grid first, then off-grid.
    part : (n,) int64
        The part, connected by couplings, of each unknown.
    size : (parts,) int64
        Unknowns of each part without ties, 0 for the others.
    """

    matrix: sparse.csr_matrix
    places: NDArray[np.int64]
    part: NDArray[np.int64]
    size: NDArray[np.int64]

    def balanced(self, values: Float64) -> Float64:
        """Subtract the mean of each part without ties: no heights can change that of a load, and none matters.

        Rounding on the finer levels makes it grow otherwise.
        """
        if not self.size.any():
            return values
        total = np.bincount(self.part, values, minlength=len(self.size))
        mean = np.divide(total, self.size, out=np.zeros(len(self.size)), where=self.size > 0)
        return values - mean[self.part]


def assemble(level: Stencil) -> Coarsest:
    """Return the system of a level; its diagonal is summed in float64."""
    rows, cols = level.shape
    size, off_grid = level.size, level.off_grid
    active = np.concatenate([level.diagonal > 0, off_grid.diagonal > 0])
    number = np.cumsum(active) - 1
    place = np.arange(size).reshape(rows, cols)
    ends: list[tuple[np.ndarray, np.ndarray, Values]] = []
    for name, down, across in (("e", 0, 1), ("s", 1, 0), ("se", 1, 1), ("sw", 1, -1)):
        values = inner(level.couplings[name], level.shape)
        here = place[: rows - down, max(-across, 0) : cols - max(across, 0)].ravel()
        found = here[values.ravel()[here] != 0]
        ends.append((found, found + down * cols + across, values.ravel()[found]))
    near, among = off_grid.to_grid, off_grid.among
    once = among.row < among.column
    ends.append((off_grid.near[near.row], size + near.column, near.value))
    ends.append((size + among.row[once], size + among.column[once], among.value[once]))
    one, two = (number[np.concatenate([end[i] for end in ends])] for i in (0, 1))
    value = np.concatenate([end[2] for end in ends]).astype(np.float64)
    count = int(active.sum())
    tie = np.concatenate([inner(level.tie, level.shape).ravel(), off_grid.tie])[active].astype(np.float64)
    couplings = sparse.csr_matrix(
        (np.concatenate([value, value]), (np.concatenate([one, two]), np.concatenate([two, one]))),
        shape=(count, count),
    )
    total = np.asarray(couplings.sum(axis=1)).ravel()
    matrix = (sparse.diags(total + tie) - couplings).tocsr()
    parts, part = sparse.csgraph.connected_components(couplings, directed=False)
    ties, sums = (np.bincount(part, each, minlength=parts) for each in (tie, total))
    loose = ties <= _NO_TIE * sums
    if loose.any():
        # the constant is free there, so any will do
        _, first = np.unique(part, return_index=True)
        more = np.zeros(count)
        more[first[loose]] = np.maximum(total[first[loose]], 1e-300)
        matrix = (matrix + sparse.diags(more)).tocsr()
    unknowns = np.where(loose, np.bincount(part, minlength=parts), 0)
    return Coarsest(matrix, np.flatnonzero(active), part.astype(np.int64), unknowns)


def coarse_solver(matrix: sparse.csr_matrix) -> Callable[[Float64], Float64]:
    """Return an approximate inverse, symmetric and positive: LU for small matrices, else two Ruge-Stueben cycles."""
    if matrix.shape[0] <= _DIRECT:
        if matrix.shape[0] == 0:
            return lambda b: b
        from scipy.sparse.linalg import splu

        solve: Callable[[Float64], Float64] = splu(
            matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        ).solve
        return solve
    cycle = hierarchy_of(matrix).aspreconditioner(cycle="V")

    def twice(b: Float64) -> Float64:
        x: Float64 = cycle @ b
        x += cycle @ (b - matrix @ x)
        return x

    return twice

"""Any mask, any weights: conjugate gradients preconditioned by a Ruge-Stueben hierarchy of the assembled matrix."""

from __future__ import annotations

import warnings

import numpy as np
from scipy import sparse

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import corner_sum
from nmaptool.solver.amg_hierarchy import hierarchy_of
from nmaptool.solver.islands import Islands
from nmaptool.solver.method import Report
from nmaptool.solver.system import QuadSystem


def assemble(system: QuadSystem, unknown: Mask) -> sparse.csr_matrix:
    """Return the operator restricted to the ``unknown`` vertices as a CSR matrix: a 9-point stencil without zeros.

    Parameters
    ----------
    system : QuadSystem
    unknown : (H+1, W+1) bool
    """
    rows, cols = system.weight.shape
    k = np.zeros((rows + 2, cols + 2))
    k[1:-1, 1:-1] = system.weight / 4
    nw, ne, sw, se = k[:-1, :-1], k[:-1, 1:], k[1:, :-1], k[1:, 1:]
    diagonal = 0.75 * corner_sum(system.weight) + system.beta
    stencil = (-nw, -(nw + ne), -ne, -(nw + sw), diagonal, -(ne + se), -sw, -(sw + se), -se)
    count = int(unknown.sum())
    index = np.full((rows + 3, cols + 3), -1, np.int32)
    index[1:-1, 1:-1][unknown] = np.arange(count, dtype=np.int32)
    columns = np.empty((count, 9), np.int32)
    values = np.empty((count, 9))
    for place in range(9):
        down, across = divmod(place, 3)
        columns[:, place] = index[down : down + rows + 1, across : across + cols + 1][unknown]
        values[:, place] = stencil[place][unknown]
    keep = (columns >= 0) & (values != 0)
    pointer = np.zeros(count + 1, np.int32)
    np.cumsum(keep.sum(axis=1), out=pointer[1:])
    return sparse.csr_matrix((values[keep], columns[keep], pointer), shape=(count, count))


class AmgMethod:
    """One hierarchy, any number of right-hand sides.

    Parameters
    ----------
    system : QuadSystem
    islands : Islands
        Its anchors, one per floating island, are left out of the matrix, as are the held vertices.
    """

    name = "amg"
    precision = np.float64

    def __init__(self, system: QuadSystem, islands: Islands) -> None:
        self._unknown = system.unknown & ~islands.anchors
        self._matrix = assemble(system, self._unknown)
        self._hierarchy = hierarchy_of(self._matrix) if self._matrix.shape[0] else None

    def improve(
        self, z: Float64, residual: Float64, reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """Preconditioned conjugate gradients from zero; see `nmaptool.solver.method.Method`."""
        from pyamg import krylov

        b = residual[self._unknown]
        start = float(np.linalg.norm(b))
        if self._hierarchy is None or start == 0:
            return (0.0,)
        seen: list[float] = []

        def notify(_: Float64) -> None:
            if report is not None and len(seen) > 1:
                report(seen[-1] / start)

        # pyamg warns about small curvature despite warning filters; hidden by recording, because the residual decides
        with warnings.catch_warnings(record=True):
            x, _ = krylov.cg(
                self._matrix,
                b,
                tol=reduction,
                maxiter=max_iterations,
                M=self._hierarchy.aspreconditioner(cycle="V"),
                residuals=seen,
                callback=notify,
            )
        if np.isfinite(x).all():
            z[self._unknown] += x
        return tuple(r / start for r in seen[1:]) or (0.0,)

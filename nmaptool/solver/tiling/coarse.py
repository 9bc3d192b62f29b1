"""The coarse problem: sums over all tiles, solved in memory."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import ConvergenceError
from nmaptool.solver.prepare import Solver, prepare
from nmaptool.solver.system import QuadSystem
from nmaptool.solver.tiling.grid import Tile, TileGrid
from nmaptool.solver.tiling.transfer import coarse_box

# the tiles correct what is left
_REDUCTION = 1e-5
_ENOUGH = 1e-2


def empty_sum(grid: TileGrid) -> Float64:
    """Zeros for sums at the coarse vertices, with one more row and column for weights that are 0."""
    rows, cols = grid.coarse_shape
    return np.zeros((rows + 2, cols + 2))


def add_block(total: Float64, block: Float64, grid: TileGrid, tile: Tile) -> None:
    """Add what a tile restricted, see `nmaptool.solver.tiling.tile.restricted`, to the sums, in place."""
    total[coarse_box(grid.vertices(tile), grid.factor)] += block


class CoarseProblem:
    """The system on the coarse grid.

    It is the fine one for heights that are interpolated from the coarse grid: exact for constant heights of each motif,
    also beside held vertices, and within the square of the grid's width for others.

    Parameters
    ----------
    weight : (Hc, Wc) float64
        Mean weight of the faces in each coarse face.
    tie : (Hc+2, Wc+2) float64
        The restricted product of the system with ones at all unknown vertices.
    reach : (Hc+2, Wc+2) float64
        The restricted number of unknown vertices; coarse vertices without any are held.
    """

    def __init__(self, weight: Float64, tie: Float64, reach: Float64) -> None:
        self._held = reach[:-1, :-1] <= 0
        self._solver: Solver | None = None
        if weight.any() and not self._held.all():
            beta = np.maximum(tie[:-1, :-1], 0)
            system = QuadSystem(weight.astype(np.float32), beta.astype(np.float32), self._held)
            self._solver = prepare(system, "multigrid")

    def solve(self, residual: Float64) -> Float64:
        """(Hc+2, Wc+2) float64 correction at the coarse vertices for a restricted residual."""
        out = np.zeros(residual.shape)
        if self._solver is None:
            return out
        load = np.where(self._held, 0.0, residual[:-1, :-1])
        try:
            found = self._solver.solve(load, tolerance=_REDUCTION)
        except ConvergenceError:
            found = self._solver.solve(load, tolerance=_ENOUGH)
        out[:-1, :-1] = found.z
        return out

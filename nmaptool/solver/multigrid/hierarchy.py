"""Levels from the finest to the coarsest, and the V-cycle over them."""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np
from numpy.typing import DTypeLike

import nmaptool.kernels.coarsening as coarsening
from nmaptool import kernels
from nmaptool.core.parallel import for_each_band
from nmaptool.kernels.coarsening import BACK, DIRECTIONS, WEIGHTS
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.coarsest import assemble, coarse_solver
from nmaptool.solver.multigrid.finest import Finest
from nmaptool.solver.multigrid.level import Shape, Stencil, inner, margin, new_field, rows_at_once
from nmaptool.solver.multigrid.off_grid import coarse_off_grid, none, transfer
from nmaptool.solver.multigrid.relaxation import Relaxation
from nmaptool.solver.multigrid.transfer import Transfer
from nmaptool.solver.system import QuadSystem

# a grid this small, or a level with this share of off-grid vertices, is solved algebraically
_SMALLEST = 2000
_MOST_STRAYS = 0.4
# up to _FEW coarse vertices, a second thread does not pay; _BAND limits a band, which needs about 70 arrays in NumPy
_FEW, _BAND = 20_000, 1 << 16


def coarsen(fine: Finest | Stencil) -> tuple[Transfer, Stencil]:
    """Return the transfer to the next coarser level, and that level."""
    shape: Shape = (fine.shape[0] + 1) // 2, (fine.shape[1] + 1) // 2
    weights = {name: new_field(shape, fine.dtype) for name in WEIGHTS}
    couplings = {name: new_field(shape, fine.dtype) for name in DIRECTIONS}
    tie = new_field(shape, fine.dtype)
    results = (*weights.values(), *couplings.values(), tie)
    if isinstance(fine, Finest):
        _in_bands(shape, lambda first, last: fine.coarsen(results, first, last))
        return Transfer(fine.shape, shape, weights, None), Stencil(shape, couplings, tie, none(fine.dtype))
    inputs = (*fine.ordered, fine.tie, fine.to_off_grid())
    stray, scale, lack, rest = back = tuple(np.zeros(fine.size, fine.dtype) for _ in BACK)
    loops = kernels.coarsen_coarse if fine.dtype == np.float32 else coarsening.coarsen_coarse
    _in_bands(shape, lambda first, last: loops(inputs, (*results, *back), *fine.shape, first, last))
    became = np.flatnonzero(stray)
    if not fine.off_grid.count and not len(became):
        return Transfer(fine.shape, shape, weights, None), Stencil(shape, couplings, tie, none(fine.dtype))
    moved = transfer(fine.off_grid, fine.couplings, fine.shape, became, scale)
    sums = fine.diagonal - inner(fine.tie, fine.shape).ravel()
    off_grid = coarse_off_grid(fine.off_grid, moved, fine.couplings, fine.shape, weights, sums, rest, lack)
    return Transfer(fine.shape, shape, weights, moved), Stencil(shape, couplings, tie, off_grid)


def _in_bands(shape: Shape, work: Callable[[int, int], object]) -> None:
    """Call ``work`` with the first and last row of each band of the coarse level."""
    for_each_band(shape[0], rows_at_once(shape, _FEW, _BAND), lambda band: work(band.start, band.stop))


class Hierarchy:
    """A preconditioner: one V-cycle, symmetric and positive definite.

    Parameters
    ----------
    system : QuadSystem
    dtype : float32 or float64
    """

    def __init__(self, system: QuadSystem, dtype: DTypeLike) -> None:
        self.finest = Finest(system, dtype)
        self.transfers: list[Transfer] = []
        self.relaxations: list[Relaxation] = []
        level: Finest | Stencil = self.finest
        while True:
            way, below = coarsen(level)
            if isinstance(level, Stencil):
                level.forget_ties()
            level = below
            self.transfers.append(way)
            active = int(np.count_nonzero(level.diagonal)) + level.off_grid.count
            few = min(level.size, active) <= _SMALLEST
            if few or level.off_grid.count > _MOST_STRAYS * active:
                break
            self.relaxations.append(Relaxation(level))
        # the right-hand side of each coarse level
        self._loads = [np.empty(way.coarse[0] * way.coarse[1], self.finest.dtype) for way in self.transfers]
        self._factor = 1.0
        self.last = level
        self._coarsest = assemble(level)
        self._solve = coarse_solver(self._coarsest)

    def under(self, system: QuadSystem, factor: float) -> Hierarchy:
        """Return a hierarchy with these coarse levels and the finest level of a similar system.

        Parameters
        ----------
        system : QuadSystem
        factor : float
            Approximate ratio of its weights to those that the levels were built for.

        Returns
        -------
        Hierarchy
            It shares its work space with this one.
        """
        other = copy.copy(self)
        other.finest = Finest(system, self.finest.dtype)
        other._factor = factor
        return other

    def cycle(self, residual: Values, out: Values) -> float:
        """One V-cycle.

        Parameters
        ----------
        residual : flat
        out : flat
            The correction.

        Returns
        -------
        float
            Inner product of the correction and the residual.
        """
        finest, way = self.finest, self.transfers[0]
        coarse = self._loads[0]
        finest.descend(residual, way, coarse)
        if self._factor != 1:
            coarse *= 1 / self._factor
        x, _ = self._descend(0, coarse, np.zeros(0, residual.dtype))
        return finest.ascend(residual, way, x, out)

    def _descend(self, number: int, residual: Values, at_strays: Values) -> tuple[Values, Values]:
        """Return the corrections on coarse level ``number``: on the grid (with margins) and at off-grid vertices."""
        if number == len(self.relaxations):
            return self._at_bottom(residual, at_strays)
        relax, way = self.relaxations[number], self.transfers[number + 1]
        relax.load(residual, at_strays)
        relax.smooth(first=True)
        left, left_strays = relax.left()
        below = self._loads[number + 1]
        way.restrict(left, below)
        moved = way.off_grid
        down = np.zeros(0, residual.dtype)
        if moved is not None:
            down = moved.back.times(left[moved.rows])
            down[: moved.kept] += left_strays
        x, off_grid = self._descend(number + 1, below, down)
        way.prolong(x, relax.x)
        if moved is not None:
            relax.x[margin(way.fine) + moved.rows] += moved.weights.times(off_grid)
            relax.off_grid += off_grid[: moved.kept]
        relax.smooth(first=False)
        return relax.x, relax.off_grid

    def _at_bottom(self, residual: Values, at_strays: Values) -> tuple[Values, Values]:
        last = self.last
        load = np.concatenate([residual, at_strays])
        x = np.zeros(len(load), residual.dtype)
        coarsest = self._coarsest
        found = self._solve(coarsest.balanced(load[coarsest.places].astype(np.float64)))
        x[coarsest.places] = coarsest.balanced(found)
        out = new_field(last.shape, last.dtype)
        inner(out, last.shape)[:] = x[: last.size].reshape(last.shape)
        return out, x[last.size :]

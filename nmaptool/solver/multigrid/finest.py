"""The finest level: face weights instead of a matrix, and two 2x2 box sums instead of a matrix product."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

import nmaptool.kernels.coarsening as coarsening
import nmaptool.kernels.grid_twins as grid_twins
from nmaptool import kernels
from nmaptool.core.parallel import for_each_band, map_parallel
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.level import Shape, band_size, inner, margin, new_field
from nmaptool.solver.system import QuadSystem

# A is at most the sum of the weights around a vertex + beta, so 4/3 of the inverse of that sum is below 2 / A; with
# beta 0 it is Jacobi's step, 1 / diagonal
_STEP = 4 / 3


def inner_product(one: Values, two: Values) -> float:
    """Return the sum of products; not by BLAS, which would start its own threads in each of ours."""
    return float((one * two).sum())


class Finest:
    """The system itself, in float32 or float64.

    Attributes
    ----------
    shape : (int, int)
        (H+1, W+1).
    quarter : flat
        A quarter of the weight of each face, at its upper left vertex, with margins; 0 in the last row and column.
    step : (size,)
        Length of a smoothing step; 0 at vertices that are not unknown.
    """

    def __init__(self, system: QuadSystem, dtype: DTypeLike) -> None:
        self.shape: Shape = system.beta.shape
        rows, cols = self.shape
        self.size, self.edge = rows * cols, margin(self.shape)
        self.dtype = np.dtype(dtype)
        self.quarter = new_field(self.shape, dtype)
        np.multiply(system.weight, 0.25, out=inner(self.quarter, self.shape)[:-1, :-1], casting="unsafe")
        self.beta = system.beta.reshape(-1).astype(dtype, copy=False)
        self._loops: Any = kernels if self.dtype == np.float32 else grid_twins
        self.unknown = system.unknown.reshape(-1)
        self.holds = bool(system.held.any())
        self.step = np.zeros(self.size, dtype)
        self._bands = max(band_size(self.size), 16 * cols)
        for_each_band(self.size, self._bands, self._lay_step)

    def in_bands(self, work: Callable[[int, int], object]) -> None:
        """Call ``work`` with the start and stop of each band of vertices."""
        for_each_band(self.size, self._bands, lambda band: work(band.start, band.stop))

    def sum_over_bands(self, work: Callable[[int, int], float]) -> float:
        """Return the sum of ``work(start, stop)`` over all bands of vertices."""
        bands = [(first, min(first + self._bands, self.size)) for first in range(0, self.size, self._bands)]
        return math.fsum(map_parallel(bands, lambda band: work(*band)))

    def dot(self, one: Values, two: Values) -> float:
        """Return the inner product of two flat arrays without margins."""
        return self.sum_over_bands(lambda start, stop: inner_product(one[start:stop], two[start:stop]))

    def times(self, x: Values, out: Values) -> float:
        """Write A x to ``out`` (no margins), for x with margins, and return x^T A x."""

        def band(start: int, stop: int) -> float:
            product: float = self._loops.finest_product(
                self.quarter, x, self.beta, self.unknown, out, self.shape[1], start, stop, self.holds
            )
            return product

        return self.sum_over_bands(band)

    def _around(self, start: int, stop: int) -> Values:
        """Return the sum of the quarters around each vertex of a range."""
        cols, first = self.shape[1], self.edge + start
        count = stop - start
        pair = self.quarter[first - cols - 1 : first + count - 1] + self.quarter[first - cols : first + count]
        return pair[:count] + pair[cols : cols + count]

    def _lay_step(self, band: slice) -> None:
        total = self._around(band.start, band.stop)
        total *= 4
        total += self.beta[band]
        unknown = self.unknown[band]
        np.divide(_STEP, total, out=self.step[band], where=unknown & (total > 0))

    def start(self, residual: Values, z: Values) -> None:
        """Do the first smoothing step, from zero: z (with margins) from the residual."""
        edge = self.edge
        self.in_bands(
            lambda start, stop: np.multiply(
                residual[start:stop], self.step[start:stop], out=z[edge + start : edge + stop]
            )
        )

    def left_rows(self, residual: Values, z: Values, first: int, last: int) -> Values:
        """Return the (last - first, cols) residual after `start`."""
        cols = self.shape[1]
        left = np.empty((last - first, cols), self.dtype)
        self._loops.finest_left(self.quarter, z, residual, left.reshape(-1), cols, first * cols, last * cols, 1 - _STEP)
        return left

    def finish(self, residual: Values, z: Values, out: Values) -> float:
        """Do the last smoothing step, from z to ``out`` (no margins); return the inner product of out and residual."""

        def band(start: int, stop: int) -> float:
            product: float = self._loops.finest_finish(
                self.quarter, z, residual, self.step, out, self.shape[1], start, stop, 1 - _STEP
            )
            return product

        return self.sum_over_bands(band)

    def coarsen(self, results: tuple[Values, ...], first: int, last: int) -> None:
        """Write rows ``first`` to ``last`` of the next coarser level; see `nmaptool.kernels.coarsening`."""
        loops = kernels.coarsen_finest if self.dtype == np.float32 else coarsening.coarsen_finest
        loops((self.quarter, self.beta, self.unknown), results, *self.shape, first, last, self.holds)

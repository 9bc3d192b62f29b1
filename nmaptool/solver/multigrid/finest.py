"""The finest level: face weights instead of a matrix, and two 2x2 box sums instead of a matrix product."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

import nmaptool.kernels.coarsening as coarsening
import nmaptool.kernels.sweep_twins as sweep_twins
from nmaptool import kernels
from nmaptool.core.parallel import for_each_band, map_parallel
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.level import Shape, band_size, inner, margin, new_field, rows_at_once
from nmaptool.solver.multigrid.transfer import Transfer
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
        self._loops: Any = kernels if self.dtype == np.float32 else sweep_twins
        self.unknown = system.unknown.reshape(-1)
        self.holds = bool(system.held.any())
        self.step = np.zeros(self.size, dtype)
        self._bands = max(band_size(self.size), 16 * cols)
        for_each_band(self.size, self._bands, self._lay_step)

    def sum_over_bands(self, work: Callable[[int, int], float]) -> float:
        """Return the sum of ``work(start, stop)`` over all bands of vertices."""
        bands = [(first, min(first + self._bands, self.size)) for first in range(0, self.size, self._bands)]
        return math.fsum(map_parallel(bands, lambda band: work(*band)))

    def dot(self, one: Values, two: Values) -> float:
        """Return the inner product of two flat arrays without margins."""
        return self.sum_over_bands(lambda start, stop: inner_product(one[start:stop], two[start:stop]))

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

    def descend(self, residual: Values, way: Transfer, out: Values) -> None:
        """Restrict what one smoothing step from zero leaves of ``residual`` to ``out``, (coarse vertices,)."""

        def band(part: slice) -> None:
            self._loops.finest_descend(
                *((self.quarter, self.step, residual), way.ordered, (out,), *self.shape),
                *(part.start, part.stop, 1 - _STEP),
            )

        for_each_band(way.coarse[0], rows_at_once(way.coarse), band)

    def ascend(self, residual: Values, way: Transfer, x: Values, out: Values) -> float:
        """Interpolate ``x`` (with margins), do the last smoothing step and return its inner product with ``residual``.

        ``out`` is (size,).
        """

        def band(part: slice) -> float:
            product: float = self._loops.finest_ascend(
                *((self.quarter, self.step, residual, x), way.ordered, (out,), *self.shape),
                *(part.start, part.stop, 1 - _STEP),
            )
            return product

        return math.fsum(map_parallel(_bands(way.coarse), band))

    def advance(self, direction: Values, other: Values, turn: float) -> float:
        """Turn a direction and multiply it by A.

        Parameters
        ----------
        direction : flat with margins
            Becomes ``turn`` times itself plus ``other``.
        other : (size,)
            Becomes A times the direction.
        turn : float

        Returns
        -------
        float
            The product of both.
        """
        cols, bands = self.shape[1], _bands(self.shape)

        def turned(row: int) -> Values:
            """Return a row of the new direction, and one number more; zeros outside."""
            out = np.zeros(cols + 1, self.dtype)
            if 0 <= row < self.shape[0]:
                here = self.edge + row * cols
                np.multiply(direction[here : here + cols], turn, out=out[:cols])
                out[:cols] += other[row * cols : (row + 1) * cols]
            return out

        # bands write to both arrays, so what they read of each other is computed first
        beside = [(turned(band.start - 1), turned(band.stop)) for band in bands]

        def work(number: int) -> float:
            band = bands[number]
            product: float = self._loops.finest_advance(
                *((self.quarter, self.beta, self.unknown, *beside[number]), (direction, other), *self.shape),
                *(band.start, band.stop, turn, self.holds),
            )
            return product

        return math.fsum(map_parallel(range(len(bands)), work))

    def coarsen(self, results: tuple[Values, ...], first: int, last: int) -> None:
        """Write rows ``first`` to ``last`` of the next coarser level; see `nmaptool.kernels.coarsening`."""
        loops = kernels.coarsen_finest if self.dtype == np.float32 else coarsening.coarsen_finest
        loops((self.quarter, self.beta, self.unknown), results, *self.shape, first, last, self.holds)


def _bands(shape: Shape) -> list[slice]:
    """Return the bands of rows of a grid."""
    at_once = rows_at_once(shape)
    return [slice(first, min(first + at_once, shape[0])) for first in range(0, shape[0], at_once)]

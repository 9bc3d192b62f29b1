"""The arrays of one level of the hierarchy, and the passes over them in every cycle.

Arrays are flat with a margin of one row and one element at both ends, so all eight neighbours are at constant offsets.
Values read across the end of a row are multiplied by a coupling of zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from nmaptool.core.parallel import for_each_band
from nmaptool.kernels.coarsening import DIRECTIONS
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.off_grid import OffGrid

Shape = tuple[int, int]
# most elements in a band: with smaller bands, threads wait for each other longer than they compute
_BAND = 3 << 16
# up to this many elements, a second thread does not pay
_FEW = 150_000


def margin(shape: Shape) -> int:
    """Return the number of elements before the first and after the last vertex of a field."""
    return shape[1] + 1


def new_field(shape: Shape, dtype: DTypeLike) -> Values:
    """Return zeros for a level, with margins."""
    return np.zeros(shape[0] * shape[1] + 2 * margin(shape), dtype)


def inner(values: Values, shape: Shape) -> Values:
    """Return a (rows, cols) view of a field without its margins."""
    edge = margin(shape)
    return values[edge : edge + shape[0] * shape[1]].reshape(shape)


def in_bands(size: int, work: Callable[[int, int], object]) -> None:
    """Call ``work`` with the start and stop of each band of a flat array."""
    for_each_band(size, band_size(size), lambda band: work(band.start, band.stop))


def band_size(size: int, few: int = _FEW, most: int = _BAND) -> int:
    """Return the elements per band: all if they are few, else such that an even number of bands is nearly full."""
    return size if size <= few else -(-size // (2 * -(-size // (2 * most))))


def rows_at_once(shape: Shape, few: int = _FEW, most: int = _BAND) -> int:
    """Return the number of rows in a band; see `band_size`."""
    return -(-band_size(shape[0] * shape[1], few, most) // shape[1])


@dataclass(eq=False)
class Stencil:
    """Couplings of a coarse level.

    Attributes
    ----------
    shape : (int, int)
    couplings : mapping of str to flat arrays with margins
        Couplings to the east, south, south-east and south-west.
    tie : flat array with margins
        Coupling to fixed heights.
    off_grid : OffGrid
    """

    shape: Shape
    couplings: dict[str, Values]
    tie: Values
    off_grid: OffGrid

    def __post_init__(self) -> None:
        size, edge = self.shape[0] * self.shape[1], margin(self.shape)
        self.edge, self.size = edge, size
        self.dtype = self.tie.dtype
        self.diagonal = self.tie[edge : edge + size].copy()
        self.diagonal[self.off_grid.near] += self.off_grid.sums_at_grid()
        self.inverse = np.zeros(size, self.dtype)
        steps = self._steps()

        def add_up(start: int, stop: int) -> None:
            total = self.diagonal[start:stop]
            for values, step in steps:
                total += values[edge + start : edge + stop]
                total += values[edge + start - step : edge + stop - step]
            np.divide(1, total, out=self.inverse[start:stop], where=total > 0)

        in_bands(size, add_up)

    def forget_ties(self) -> None:
        """Free the memory of the ties, which only coarsening needs."""
        self.tie = np.zeros(0, self.dtype)

    def _steps(self) -> list[tuple[Values, int]]:
        cols = self.shape[1]
        return list(zip((self.couplings[d] for d in DIRECTIONS), (1, cols, cols + 1, cols - 1), strict=True))

    @property
    def ordered(self) -> list[Values]:
        """The couplings to the east, south, south-east and south-west."""
        return [self.couplings[direction] for direction in DIRECTIONS]

    def to_off_grid(self) -> Values:
        """Return the (size,) couplings to off-grid vertices; an empty array if there are none."""
        if not self.off_grid.count:
            return np.zeros(0, self.dtype)
        out = np.zeros(self.size, self.dtype)
        out[self.off_grid.near] = self.off_grid.sums_at_grid()
        return out

"""The operator without a matrix, in bands of rows on all cores.

With dx and dy the differences of heights along the edges of the grid, (L z)_v is a quarter of

    2 (W dx to the left - W dx to the right) + (w (dy + dy) of the faces above - of the faces below)

where W is the sum of the weights of the two faces at an edge. Taking differences first avoids rounding errors where
heights are large and smooth.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nmaptool.kernels.system_twins as system_twins
from nmaptool import kernels
from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.parallel import for_each_band

# with slices of this size, NumPy's threads wait little for the interpreter lock
ELEMENTS_AT_ONCE = 1 << 16

Weights = NDArray[np.floating[Any]]
# called with a band of rows, its (rows * (W+1),) A z and a work array of that size; both arrays may be overwritten
Finish = Callable[[slice, Float64, Float64], None]


def rows_at_once(columns: int) -> int:
    """Return the number of rows per band for an array with this many columns."""
    return max(1, ELEMENTS_AT_ONCE // columns)


class Operator:
    """Computes A z of a system, one band at a time.

    Parameters
    ----------
    weight : (H, W) float32 or float64
    beta : (H+1, W+1) float32 or float64
    """

    def __init__(self, weight: Weights, beta: Weights) -> None:
        self._weight = weight
        self._beta = beta
        is_single = weight.dtype == beta.dtype == np.float32
        self._loops: Any = kernels if is_single else system_twins
        self._rows_at_once = rows_at_once(beta.shape[1])
        # work space of one band each; reused, because allocating it costs as much as the computation
        self._spare: list[tuple[Float64, Float64]] = []

    def each(self, z: Float64 | None, finish: Finish, where: Mask | None = None) -> None:
        """Call ``finish`` with every band of A z, in any order.

        Parameters
        ----------
        z : (H+1, W+1) float64, C order, or None
            None means 0 everywhere.
        finish : callable
        where : (H+1, W+1) bool, optional
            Vertices that matter; A z may be 0 in a band without any. Default: all.
        """

        def work(band: slice) -> None:
            room = self._room()
            product, other = (part[: (band.stop - band.start) * self._beta.shape[1]] for part in room)
            if z is None or (where is not None and not where[band].any()):
                product[:] = 0
            else:
                self._loops.system_product(
                    self._weight, self._beta, z, product, *self._beta.shape, band.start, band.stop
                )
            finish(band, product, other)
            self._spare.append(room)

        for_each_band(len(self._beta), self._rows_at_once, work)

    def around(self, band: slice) -> Float64:
        """Return the (rows, W+1) sum of the face weights around each vertex of a band."""
        pairs = np.zeros((band.stop - band.start, self._beta.shape[1]))
        rows = len(self._weight)
        below, above = slice(band.start, min(band.stop, rows)), slice(max(band.start - 1, 0), band.stop - 1)
        for faces, first in ((below, 0), (above, above.start + 1 - band.start)):
            found = self._weight[faces]
            pairs[first : first + len(found), :-1] += found
        out = pairs.copy()
        out[:, 1:] += pairs[:, :-1]
        return out

    def _room(self) -> tuple[Float64, Float64]:
        try:
            return self._spare.pop()
        except IndexError:
            size = self._rows_at_once * self._beta.shape[1]
            return np.zeros(size), np.zeros(size)

"""The operator without a matrix: sums over neighbours as shifted slices of flat rows, in bands on all cores.

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
        self._rows_at_once = rows_at_once(beta.shape[1])
        # work space of one band each; reused, because allocating it costs as much as the computation
        self._spare: list[tuple[Float64, ...]] = []

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
            if z is None or (where is not None and not where[band].any()):
                product, other = (part[: (band.stop - band.start) * self._beta.shape[1]] for part in room[:2])
                product[:] = 0
            else:
                product, other = self._product(z, band, *room)
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

    def _room(self) -> tuple[Float64, ...]:
        try:
            return self._spare.pop()
        except IndexError:
            size = (self._rows_at_once + 2) * self._beta.shape[1] + 1
            return tuple(np.zeros(size) for _ in range(5))

    def _product(
        self, z: Float64, band: slice, edge: Float64, faces: Float64, a: Float64, b: Float64, c: Float64
    ) -> tuple[Float64, Float64]:
        """Return A z of a band, flat, in ``b``, and ``a`` as a work array."""
        stride = z.shape[1]
        count = (band.stop - band.start) * stride
        heights = self._heights(z, band, edge)
        half = self._halves(band, faces)
        here = heights[stride:-stride]
        # along the rows: the flow over the left edge minus the flow over the right one
        flow = a[: count + 1]
        flow[0] = 0
        np.subtract(heights[stride + 1 : count + stride + 1], here, out=flow[1:])
        flow[1:] *= np.add(half[:-stride], half[stride:], out=b[:count])
        across = np.subtract(flow[:-1], flow[1:], out=b[:count])
        # along the columns: the same, by faces
        steps = a[: count + stride + 1]
        np.subtract(heights[stride:], heights[:-stride], out=steps[:-1])
        steps[-1] = 0
        face_flow = c[: count + stride + 1]
        face_flow[0] = 0
        np.add(steps[1:], steps[:-1], out=face_flow[1:])
        face_flow[1:] *= half
        both = np.add(face_flow[1:], face_flow[:-1], out=a[: count + stride])
        down = np.subtract(both[:-stride], both[stride:], out=c[:count])
        down *= 0.5
        across += down
        across += np.multiply(self._beta[band].reshape(-1), here, out=c[:count])
        return across, a[:count]

    def _heights(self, z: Float64, band: slice, room: Float64) -> Float64:
        """Return the heights of the band and of one row above and below it, flat; rows outside the picture are 0."""
        rows, stride = z.shape
        if band.start > 0 and band.stop < rows:
            return z[band.start - 1 : band.stop + 1].reshape(-1)
        out = room[: (band.stop - band.start + 2) * stride]
        out[:] = 0
        first, last = max(band.start - 1, 0), min(band.stop + 1, rows)
        out.reshape(-1, stride)[first - band.start + 1 : last - band.start + 1] = z[first:last]
        return out

    def _halves(self, band: slice, room: Float64) -> Float64:
        """Return half the weights of the faces above and below the band, flat, with a 0 at the end of each row."""
        rows, stride = len(self._weight), self._beta.shape[1]
        out = room[: (band.stop - band.start + 1) * stride]
        grid = out.reshape(-1, stride)
        first, last = max(band.start - 1, 0), min(band.stop, rows)
        np.multiply(self._weight[first:last], 0.5, out=grid[first - band.start + 1 : last - band.start + 1, :-1])
        grid[:, -1] = 0
        if band.start == 0:
            grid[0] = 0
        if band.stop > rows:
            grid[-1] = 0
        return out

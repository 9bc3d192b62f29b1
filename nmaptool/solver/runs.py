"""Runs of equal labels along rows; with them, sums and constants per island cost little more than one pass."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.parallel import for_each_band
from nmaptool.solver.operator import rows_at_once

Labels = NDArray[np.signedinteger[Any] | np.bool_]


class Runs:
    """The runs of equal labels along the flat rows of each band.

    Parameters
    ----------
    faces : (H, W) bool or int32
        Label of each face, 0 for none; a vertex has the label of the faces that it touches.
    count : int
        The largest label.

    Attributes
    ----------
    labels : (R,) int32
        Label of each run, over all bands.
    lengths : (R,) int
        Number of vertices in each run.
    """

    def __init__(self, faces: Labels, count: int) -> None:
        self._count = count
        rows = len(faces) + 1
        self.shape = rows, faces.shape[1] + 1
        self._step = rows_at_once(self.shape[1])
        bands = -(-rows // self._step)
        starts: list[NDArray[np.intp]] = [np.zeros(0, np.intp)] * bands
        labels: list[NDArray[np.int32]] = [np.zeros(0, np.int32)] * bands

        def cut(band: slice) -> None:
            flat = _of_vertices(faces, band).reshape(-1)
            first = np.flatnonzero(flat[1:] != flat[:-1])
            first += 1
            number = band.start // self._step
            starts[number] = np.concatenate([[0], first])
            labels[number] = flat[starts[number]].astype(np.int32)

        for_each_band(rows, self._step, cut)
        self._starts = starts
        self._places = np.concatenate([[0], np.cumsum([len(each) for each in starts])])
        self.labels = np.concatenate(labels)
        ends = [self._size(number) for number in range(bands)]
        self.lengths = np.concatenate([np.diff(s, append=end) for s, end in zip(starts, ends, strict=True)])

    def _size(self, number: int) -> int:
        """Return the number of vertices in a band."""
        return int((min((number + 1) * self._step, self.shape[0]) - number * self._step) * self.shape[1])

    def of(self, band: slice) -> slice:
        """Return the indices of the runs in a band, as a slice."""
        number = band.start // self._step
        return slice(int(self._places[number]), int(self._places[number + 1]))

    def add(self, band: slice, values: NDArray[Any]) -> NDArray[Any]:
        """Return the sum of (rows * (W+1),) values over each run of the band."""
        return np.asarray(np.add.reduceat(values, self._starts[band.start // self._step]))

    def sums(self, of: Callable[[slice], Float64]) -> Float64:
        """Return the (count+1,) sums per label of the flat values that ``of`` returns for each band."""
        found = np.empty(len(self.labels))

        def look(band: slice) -> None:
            found[self.of(band)] = self.add(band, of(band))

        for_each_band(self.shape[0], self._step, look)
        return self.total(found)

    def total(self, of_runs: Float64) -> Float64:
        """Return the (count+1,) sums per label of (R,) values per run."""
        return np.bincount(self.labels, of_runs, minlength=self._count + 1).astype(np.float64, copy=False)

    def spread(self, band: slice, of_labels: NDArray[Any]) -> NDArray[Any]:
        """Return the value of each vertex of a band, (rows * (W+1),), from (count+1,) values per label."""
        runs = self.of(band)
        return np.repeat(of_labels[self.labels[runs]], self.lengths[runs])

    def each(self, work: Callable[[slice], object]) -> None:
        """Call ``work`` with every band."""
        for_each_band(self.shape[0], self._step, work)

    def firsts(self) -> NDArray[np.intp]:
        """Return the (count+1,) flat index of the first vertex of each label; undefined for labels without vertices."""
        found = np.zeros(self._count + 1, np.intp)
        places = np.cumsum(self.lengths) - self.lengths
        found[self.labels[::-1]] = places[::-1]  # reversed, so that the first run of each label is written last
        return found

    def map(self) -> NDArray[np.int32]:
        """Return the (H+1, W+1) label of each vertex."""
        return np.repeat(self.labels, self.lengths).reshape(self.shape)


def _of_vertices(faces: Labels, band: slice) -> NDArray[Any]:
    """Return the (rows, W+1) largest label of the faces around each vertex of a band."""
    columns = faces.shape[1] + 1
    out = np.zeros((band.stop - band.start, columns), faces.dtype)
    above = faces[max(band.start - 1, 0) : band.stop - 1]
    below = faces[band.start : band.stop]
    for part, first in ((above, len(out) - len(above)), (below, 0)):
        for where in (out[first : first + len(part), :-1], out[first : first + len(part), 1:]):
            np.maximum(where, part, out=where)
    return out

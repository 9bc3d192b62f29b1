"""The part of a picture that a solve works on: the box around its unknown vertices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.solver.system import QuadSystem

# the box begins at a multiple of this, so that multigrid's upper levels have the same vertices as without it
_ALIGNED = 64
# a box with more than this share of the picture is not worth its copies
_MOST_SHARE = 0.9
_Values = TypeVar("_Values", bound=NDArray[Any])


@dataclass(frozen=True, eq=False)
class Window:
    """A box that contains all unknown vertices; every vertex outside is held, or has no height.

    Attributes
    ----------
    rows, cols : slice
        Of vertices.
    held : (H+1, W+1) bool
        Held vertices of the whole picture.
    """

    rows: slice
    cols: slice
    held: Mask

    @property
    def is_whole(self) -> bool:
        """Whether the box is the whole picture."""
        return (self.rows.stop - self.rows.start, self.cols.stop - self.cols.start) == self.held.shape

    def cut(self, values: _Values) -> _Values:
        """Return the (rows, columns) part of an (H+1, W+1) array, in C order; the array itself if it is whole."""
        if self.is_whole:
            return values
        return np.ascontiguousarray(values[self.rows, self.cols])  # type: ignore[return-value]

    def place(self, z: Float64, held_z: Float64 | None) -> Float64:
        """Return (H+1, W+1) heights from those of the box; outside, held vertices have ``held_z``, others 0."""
        if self.is_whole:
            return z
        out = np.zeros(self.held.shape)
        if held_z is not None:
            np.copyto(out, held_z, where=self.held)
        out[self.rows, self.cols] = z
        return out

    def system(self, whole: QuadSystem) -> QuadSystem:
        """Return the part of a system in this box."""
        if self.is_whole:
            return whole
        faces = whole.weight[self.rows.start : self.rows.stop - 1, self.cols.start : self.cols.stop - 1]
        return QuadSystem(np.ascontiguousarray(faces), self.cut(whole.beta), self.cut(whole.held))


def window_of(system: QuadSystem) -> Window:
    """Return the box around the unknown vertices of a system; the whole picture if that is hardly larger."""
    unknown = system.unknown
    rows, cols = (
        _range(np.asarray(unknown.any(axis=axis)), size) for axis, size in zip((1, 0), unknown.shape, strict=True)
    )
    area = (rows.stop - rows.start) * (cols.stop - cols.start)
    if area == 0 or area > _MOST_SHARE * unknown.size:
        rows, cols = slice(0, unknown.shape[0]), slice(0, unknown.shape[1])
    return Window(rows, cols, system.held)


def _range(found: Mask, size: int) -> slice:
    """Return the smallest aligned range of all places found, with one more place at either end."""
    places = np.flatnonzero(found)
    if not len(places):
        return slice(0, 0)
    first = max(int(places[0]) - 1, 0) // _ALIGNED * _ALIGNED
    return slice(first, min(int(places[-1]) + 2, size))

"""Fill small holes in a surface, such as the dropouts of a depth camera, from the heights around them.

The fill is the surface with the least bending that joins the heights around a hole. Where a jump runs into a hole, the
hole is divided along a smooth line, and the two sides do not bend each other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places

_Ints = NDArray[np.intp]
_Stencil = tuple[tuple[tuple[int, int], ...], tuple[float, ...]]
# gives the values at known places beside pixels of holes
_Values = Callable[[tuple[_Ints, _Ints], _Ints], NDArray[Any]]
# the heights around a hole lie on two sides if the largest gap between them is this share of their range
_GAP_SHARE = 0.6
_HALF = 0.5
# offsets and weights of the equations: second differences along rows, columns and diagonals; and differences to the
# neighbours, which decide only where second differences do not
_BENDS: tuple[_Stencil, ...] = (
    (((0, -1), (0, 0), (0, 1)), (1.0, -2.0, 1.0)),
    (((-1, 0), (0, 0), (1, 0)), (1.0, -2.0, 1.0)),
    (((-1, -1), (0, 0), (1, 1)), (0.5, -1.0, 0.5)),
    (((-1, 1), (0, 0), (1, -1)), (0.5, -1.0, 0.5)),
)
_STRETCHES: tuple[_Stencil, ...] = (
    (((0, 0), (0, 1)), (-0.02, 0.02)),
    (((0, 0), (1, 0)), (-0.02, 0.02)),
)
# makes the equations solvable where a pixel is joined to no other
_ANCHOR = 1e-9
# pixels solved for at once, and the largest offset in the equations
_PART, _MARGIN = 20_000, 2
# larger holes are not filled: this many pixels take 15 s and 1 GB
MOST_PIXELS = 200_000


@dataclass(frozen=True, eq=False)
class Filled:
    """Heights with small holes filled.

    Attributes
    ----------
    heights : (H, W) float32
    pixels : (H, W) bool or None
        The pixels that were filled; None if there are none.
    count : int
        Number of holes.
    too_large : int
        Pixels of the largest hole that is narrow enough but has more than `MOST_PIXELS`; 0 if there is none.
    """

    heights: Float32
    pixels: Mask | None = None
    count: int = 0
    too_large: int = 0


def fill_holes(
    heights: Float32, known: Mask, dropouts: Mask, most_px: float, jump_px: float, longest_px: int | None = None
) -> Filled:
    """Fill holes that consist of dropouts alone, are no wider than ``most_px``, and do not touch the picture's edge.

    Holes of more than `MOST_PIXELS` are left.

    Parameters
    ----------
    heights : (H, W) float32
        Heights in px.
    known, dropouts : (H, W) bool
        Pixels that have a height, and those without one that may be filled.
    most_px : float
        Largest width of a hole.
    jump_px : float
        Smallest jump.
    longest_px : int, optional
        Leave holes that span more rows or columns.
    """
    labels, count, too_large = _small_holes(known, dropouts, most_px, longest_px)
    if not count:
        return Filled(heights, too_large=too_large)
    out = heights.copy()
    _Holes(heights, known, labels, count).fill(out, jump_px)
    return Filled(out, labels > 0, count, too_large)


def _small_holes(
    known: Mask, dropouts: Mask, most_px: float, longest_px: int | None
) -> tuple[NDArray[np.int32], int, int]:
    """Return the numbers of the holes to fill, from 1, how many there are, and `Filled.too_large`."""
    unknown = (~known).view(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(unknown, connectivity=8, ltype=cv2.CV_32S)
    # distances to the nearest known pixel: a hole of w pixels has (w + 1) / 2
    depth = cv2.distanceTransform(unknown, cv2.DIST_L2, 5)
    keep = np.ones(count, bool)
    keep[labels[depth > (most_px + 1) / 2 + 0.1]] = False
    keep[labels[(unknown > 0) & ~dropouts]] = False
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        keep[edge] = False
    keep[0] = False
    if longest_px is not None:
        keep &= stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) <= longest_px
    sizes = stats[:, cv2.CC_STAT_AREA]
    too_large = keep & (sizes > MOST_PIXELS)
    keep &= ~too_large
    number = np.zeros(count, np.int32)
    number[keep] = np.arange(1, int(keep.sum()) + 1)
    return number[labels], int(keep.sum()), int(sizes.max(where=too_large, initial=0))


class _Holes:
    """The holes of a picture: their pixels in the order of the holes, and the heights around them."""

    def __init__(self, heights: Float32, known: Mask, labels: NDArray[np.int32], count: int) -> None:
        self.heights, self.known, self.labels, self.count = heights, known, labels, count
        row, col = places(labels > 0)
        order = np.argsort(labels[row, col], kind="stable")
        self.row, self.col = row[order], col[order]

    def within(self, at: tuple[_Ints, _Ints]) -> tuple[_Ints, _Ints, Mask]:
        """Return the rows and columns of places, moved into the picture, and whether they were in it."""
        rows, cols = self.known.shape
        inside = (at[0] >= 0) & (at[0] < rows) & (at[1] >= 0) & (at[1] < cols)
        return at[0].clip(0, rows - 1), at[1].clip(0, cols - 1), inside

    def splits(self, jump_px: float) -> Float32:
        """Return the height between the two sides around each hole, by its number; infinite if there is one side."""
        hole, value = [], []
        for down in range(-_MARGIN, _MARGIN + 1):
            for right in range(-_MARGIN, _MARGIN + 1):
                row, col, inside = self.within((self.row + down, self.col + right))
                there = inside & self.known[row, col]
                hole.append(self.labels[self.row[there], self.col[there]])
                value.append(self.heights[row[there], col[there]])
        holes, values = np.concatenate(hole), np.concatenate(value)
        order = np.lexsort((values, holes))
        holes, values = holes[order], values[order]
        gaps = np.append(np.where(holes[1:] == holes[:-1], np.diff(values), np.float32(-1)), np.float32(-1))
        starts = np.flatnonzero(np.r_[True, holes[1:] != holes[:-1]])
        ends = np.append(starts[1:], len(holes))
        largest = np.maximum.reduceat(gaps, starts)
        span = values[ends - 1] - values[starts]
        has_two = (largest > jump_px) & (largest > _GAP_SHARE * span)
        below = np.flatnonzero((gaps == np.repeat(largest, ends - starts)) & np.repeat(has_two, ends - starts))
        out = np.full(self.count + 1, np.inf, np.float32)
        out[holes[below]] = (values[below] + values[below + 1]) / 2
        return out

    def fill(self, out: Float32, jump_px: float) -> None:
        """Write the heights of all holes, some holes at a time."""
        split = self.splits(jump_px)
        number = self.labels[self.row, self.col]
        start = 0
        while start < len(number):
            last = number[min(start + _PART, len(number)) - 1]
            part = slice(start, int(np.searchsorted(number, last, side="right")))
            system = _System(self, self.row[part], self.col[part], split)
            out[self.row[part], self.col[part]] = system.heights()
            start = part.stop


class _System:
    """The equations of some holes."""

    def __init__(self, holes: _Holes, row: _Ints, col: _Ints, split: Float32) -> None:
        self.holes, self.row, self.col = holes, row, col
        self.number = holes.labels[row, col]
        self.split = split[self.number]
        self.top, self.left = int(row.min()) - _MARGIN, int(col.min()) - _MARGIN
        shape = (int(row.max()) - self.top + _MARGIN + 1, int(col.max()) - self.left + _MARGIN + 1)
        self.position = np.full(shape, -1, np.intp)
        self.position[row - self.top, col - self.left] = np.arange(len(row))

    def heights(self) -> Float32:
        """Return the heights of the holes' pixels."""
        is_high = np.zeros(len(self.row), bool)
        if np.isfinite(self.split).any():  # the line between the sides is smooth: a level of a stretched membrane
            above = self.solved(lambda at, pixel: self.holes.heights[at] > self.split[pixel], _STRETCHES, None)
            is_high = np.isfinite(self.split) & (above > _HALF)
        middle = float(np.median(self.holes.heights[self.holes.known]))  # subtracted for precision
        found = self.solved(lambda at, pixel: self.holes.heights[at] - middle, _BENDS + _STRETCHES, is_high)
        return np.asarray(found + middle, np.float32)

    def solved(self, value: _Values, stencils: tuple[_Stencil, ...], is_high: Mask | None) -> NDArray[np.float64]:
        """Return the values of the holes' pixels from those around; sides are not joined if ``is_high`` is given."""
        from scipy.sparse import coo_matrix, diags
        from scipy.sparse.linalg import spsolve

        size, total = len(self.row), 0
        entries: list[tuple[_Ints, _Ints, NDArray[np.float64]]] = []
        right = []
        for offsets, weights in stencils:
            for first in range(len(offsets)):  # each equation once: its earlier places have a known height
                pixel = np.arange(size)
                terms: list[tuple[_Ints, _Ints]] = []
                for number, (down, across) in enumerate(offsets):
                    at = (self.row[pixel] + down - offsets[first][0], self.col[pixel] + across - offsets[first][1])
                    sound = self._joined(at, pixel, is_high, must_be_known=number < first)
                    pixel = pixel[sound]
                    terms = [(keep[0][sound], keep[1][sound]) for keep in terms] + [(at[0][sound], at[1][sound])]
                load = np.zeros(len(pixel))
                for at, weight in zip(terms, weights, strict=True):
                    is_known = self.holes.known[at]
                    load[is_known] -= weight * value((at[0][is_known], at[1][is_known]), pixel[is_known])
                    inside = ~is_known
                    place = self.position[at[0][inside] - self.top, at[1][inside] - self.left]
                    entries.append((total + np.flatnonzero(inside), place, np.full(len(place), weight)))
                right.append(load)
                total += len(pixel)
        rows, cols, weights_in = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        matrix = coo_matrix((weights_in, (rows, cols)), shape=(total, size)).tocsr()
        normal = matrix.T @ matrix + diags(np.full(size, _ANCHOR))
        return np.asarray(np.atleast_1d(spsolve(normal.tocsc(), matrix.T @ np.concatenate(right))), np.float64)

    def _joined(self, at: tuple[_Ints, _Ints], pixel: _Ints, is_high: Mask | None, *, must_be_known: bool) -> Mask:
        """Whether places lie in the same hole as the pixels, or around it, on the same side of a jump."""
        row, col, inside = self.holes.within(at)
        at = (row, col)
        known = self.holes.known[at]
        if must_be_known:
            inside &= known
        same = known | (self.holes.labels[at] == self.number[pixel])
        if is_high is not None:
            high_there = np.where(
                known,
                self.holes.heights[at] > self.split[pixel],
                is_high[self.position[at[0] - self.top, at[1] - self.left]],
            )
            same &= high_there == is_high[pixel]
        return np.asarray(inside & same)

"""A rasteriser in NumPy: needs no graphics driver, samples exact pixel centres, and is the reference for OpenGL."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces

_PAIRS_AT_ONCE = 2_000_000
# triangles with more pixels in their box are drawn row by row: long, thin ones have large boxes
_LARGE = 256
Index = NDArray[np.int64]

# (points, faces, rows, cols) -> face at each pixel: `visible_faces`, or ``draw`` of `nmaptool.render.gl.drawing`
Draw = Callable[[Float64, Faces, int, int], NDArray[np.int32]]


def visible_faces(points: Float64, faces: Faces, rows: int, cols: int) -> NDArray[np.int32]:
    """Find the nearest face at the centre of each pixel.

    Parameters
    ----------
    points : (N, 3) float64
        Column, row and nearness of each vertex, see `nmaptool.render.camera.Camera.project`.
    faces : (M, 3) int32
    rows, cols : int
        Size of the picture.

    Returns
    -------
    (rows, cols) int32
        Face number, -1 where nothing is seen. Edges belong to both their faces; if two faces are equally near, the one
        with the higher number is seen.
    """
    shown = np.full(rows * cols, -1, np.int32)
    nearest = np.full(rows * cols, -np.inf)
    col, row = (points[:, axis][faces] for axis in (0, 1))
    # pixel centres are at .5
    sides = ((col, cols), (row, rows))
    left, top = (np.ceil(v.min(axis=1) - 0.5).clip(0, end).astype(np.int64) for v, end in sides)
    right, bottom = (np.floor(v.max(axis=1) - 0.5).clip(-1, end - 1).astype(np.int64) for v, end in sides)
    wide, high = (right - left + 1).clip(0), (bottom - top + 1).clip(0)
    is_large = wide * high > _LARGE

    def draw(face: Index, x: Index, y: Index) -> None:
        near, inside = _covered(points, faces[face], x.astype(np.float64) + 0.5, y.astype(np.float64) + 0.5)
        pixel = (y * cols + x)[inside]
        face, near = face[inside], near[inside]
        better = (near > nearest[pixel]) | ((near == nearest[pixel]) & (face > shown[pixel]))
        face, near, pixel = face[better], near[better], pixel[better]
        order = np.lexsort((face, near))  # of several writes to one pixel, the last and nearest wins
        nearest[pixel[order]] = near[order]
        shown[pixel[order]] = face[order]

    (small,) = np.nonzero(~is_large & (wide > 0))
    for part, within in _expanded((wide * high)[small]):
        face = small[part]
        y, x = np.divmod(within, wide[face])
        draw(face, x + left[face], y + top[face])
    (large,) = np.nonzero(is_large)
    for part, within in _expanded(high[large]):
        face, y = large[part], within + top[large[part]]
        first, last = _span(col[face], row[face], y + 0.5)
        first, last = np.maximum(first, left[face]), np.minimum(last, right[face])
        for each, across in _expanded((last - first + 1).clip(0)):
            draw(face[each], first[each] + across, y[each])
    return shown.reshape(rows, cols)


def _expanded(count: Index) -> Iterator[tuple[Index, Index]]:
    """Each number repeated as often as it counts, with 0, 1, ... for its repeats, in portions that fit in memory."""
    total = np.concatenate([[0], np.cumsum(count)])
    for begin in range(0, int(total[-1]), _PAIRS_AT_ONCE):
        place = np.arange(begin, min(begin + _PAIRS_AT_ONCE, int(total[-1])))
        part = np.searchsorted(total, place, side="right") - 1
        yield part, place - total[part]


def _span(col: Float64, row: Float64, y: Float64) -> tuple[Index, Index]:
    """First and last pixel of each triangle in a row, with one more on both sides for rounding."""
    low, high = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for k in range(3):
        x0, x1, y0, y1 = col[:, k], col[:, (k + 1) % 3], row[:, k], row[:, (k + 1) % 3]
        meets = (np.minimum(y0, y1) <= y) & (np.maximum(y0, y1) >= y)
        share = np.where(y1 == y0, 0.0, (y - y0) / np.where(y1 == y0, 1.0, y1 - y0))
        for x in (x0 + share * (x1 - x0), np.where(y1 == y0, x1, x0 + share * (x1 - x0))):
            low, high = np.where(meets, np.minimum(low, x), low), np.where(meets, np.maximum(high, x), high)
    known = low <= high
    first, last = np.where(known, np.floor(low - 1.5), 0), np.where(known, np.ceil(high + 0.5), -1)
    return first.astype(np.int64), last.astype(np.int64)


def _covered(points: Float64, corners: Faces, x: Float64, y: Float64) -> tuple[Float64, NDArray[np.bool_]]:
    """Nearness of each face at a position, and whether the position is inside it."""
    a, b, c = (points[corners[:, k]] for k in range(3))
    # signed double areas opposite each corner
    wa = (b[:, 0] - x) * (c[:, 1] - y) - (c[:, 0] - x) * (b[:, 1] - y)
    wb = (c[:, 0] - x) * (a[:, 1] - y) - (a[:, 0] - x) * (c[:, 1] - y)
    wc = (a[:, 0] - x) * (b[:, 1] - y) - (b[:, 0] - x) * (a[:, 1] - y)
    area = wa + wb + wc
    inside = (area != 0) & (((wa >= 0) & (wb >= 0) & (wc >= 0)) | ((wa <= 0) & (wb <= 0) & (wc <= 0)))
    near = (wa * a[:, 2] + wb * b[:, 2] + wc * c[:, 2]) / np.where(area == 0, 1, area)
    return near, inside

"""A rasteriser in NumPy: needs no graphics driver, samples exact pixel centres, and is the reference for OpenGL."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces

_PAIRS_AT_ONCE = 2_000_000

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
    wide = (right - left + 1).clip(0)
    count = wide * (bottom - top + 1).clip(0)
    for first, last, skip in _portions(count):
        face = np.repeat(np.arange(first, last), count[first:last]) if skip is None else np.full(len(skip), first)
        within = (
            np.arange(len(face)) - np.repeat(np.cumsum(count[first:last]) - count[first:last], count[first:last])
            if skip is None
            else skip
        )
        y, x = np.divmod(within, wide[face])
        y, x = y + top[face], x + left[face]
        near, inside = _covered(points, faces[face], x + 0.5, y + 0.5)
        pixel = (y * cols + x)[inside]
        face, near = face[inside], near[inside]
        better = near >= nearest[pixel]
        face, near, pixel = face[better], near[better], pixel[better]
        order = np.argsort(near, kind="stable")  # of several writes to one pixel, the last and nearest wins
        nearest[pixel[order]] = near[order]
        shown[pixel[order]] = face[order]
    return shown.reshape(rows, cols)


def _portions(count: NDArray[np.int64]) -> list[tuple[int, int, NDArray[np.int64] | None]]:
    """Ranges of faces whose candidate pixels fit in memory; a large face is alone, and its pixels are split."""
    out: list[tuple[int, int, NDArray[np.int64] | None]] = []
    total = np.concatenate([[0], np.cumsum(count)])
    first = 0
    while first < len(count):
        if count[first] > _PAIRS_AT_ONCE:
            out += [
                (first, first + 1, np.arange(begin, min(begin + _PAIRS_AT_ONCE, count[first])))
                for begin in range(0, int(count[first]), _PAIRS_AT_ONCE)
            ]
            first += 1
            continue
        last = int(np.searchsorted(total, total[first] + _PAIRS_AT_ONCE, side="right")) - 1
        if total[last] > total[first]:
            out.append((first, last, None))
        first = max(last, first + 1)
    return out


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

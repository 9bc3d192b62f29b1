"""Sums and means between the faces and the vertices of a quad grid: H x W faces, (H+1) x (W+1) vertices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask


def corner_sum(faces: NDArray[np.floating[Any]]) -> Float64:
    """(H+1, W+1) float64 sum over the faces that meet at each vertex, from (H, W).

    >>> corner_sum(np.array([[1.0, 2.0]])).tolist()
    [[1.0, 3.0, 2.0], [1.0, 3.0, 2.0]]
    """
    rows, cols = faces.shape
    out = np.zeros((rows + 1, cols + 1))
    out[:-1, :-1] += faces
    out[:-1, 1:] += faces
    out[1:, :-1] += faces
    out[1:, 1:] += faces
    return out


def corner_mean(vertices: Float64) -> Float64:
    """(H, W) mean over the four corners of each face, from (H+1, W+1)."""
    across = vertices[:, :-1] + vertices[:, 1:]
    out = across[:-1] + across[1:]
    out *= 0.25
    return out


def height_slopes(vertices: Float64) -> tuple[Float64, Float64]:
    """(H, W) slopes p = dz/dx and q = dz/dy (y up, row 0 on top) of each face, from heights at its corners."""
    across = vertices[:, 1:] - vertices[:, :-1]
    up = vertices[:-1] - vertices[1:]
    return (across[:-1] + across[1:]) / 2, (up[:, :-1] + up[:, 1:]) / 2


def places(mask: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the nonzero elements of a 2-D array, as `numpy.nonzero` gives them but much faster.

    >>> places(np.array([[False, True], [True, False]]))
    (array([0, 1]), array([1, 0]))
    """
    rows, cols = np.unravel_index(np.flatnonzero(mask), mask.shape)
    return rows, cols


def touching_corners(mask: Mask) -> tuple[Mask, Mask]:
    """(H-1, W-1) bool twice: inner vertices where two pixels of a mask touch only at a corner.

    In the first, the pixels lie at the upper left and lower right; in the second, at the upper right and lower left.
    """
    nw, ne, sw, se = mask[:-1, :-1], mask[:-1, 1:], mask[1:, :-1], mask[1:, 1:]
    return nw & se & ~ne & ~sw, ne & sw & ~nw & ~se


def found_in(ascending: NDArray[np.int64], values: NDArray[np.int64]) -> NDArray[np.int64]:
    """The place of each value in an ascending array; -1 for those that are not in it.

    >>> found_in(np.array([2, 5, 9]), np.array([5, 6])).tolist()
    [1, -1]
    """
    if not len(ascending):
        return np.full(len(values), -1)
    at = np.minimum(np.searchsorted(ascending, values), len(ascending) - 1)
    return np.where(ascending[at] == values, at, -1)


def touching_vertices(faces: Mask) -> Mask:
    """(H+1, W+1) bool: vertices that touch a face of the (H, W) mask."""
    rows, cols = faces.shape
    out = np.zeros((rows + 1, cols + 1), bool)
    out[:-1, :-1] |= faces
    out[:-1, 1:] |= faces
    out[1:, :-1] |= faces
    out[1:, 1:] |= faces
    return out


def dilated(mask: Mask, px: int) -> Mask:
    """(H, W) bool: pixels within ``px`` rows and columns of an (H, W) mask.

    >>> dilated(np.array([[True, False, False]]), 1).tolist()
    [[True, True, False]]
    """
    down = mask.copy()
    for step in range(1, min(px, len(mask) - 1) + 1):
        down[step:] |= mask[:-step]
        down[:-step] |= mask[step:]
    out = down.copy()
    for step in range(1, min(px, mask.shape[1] - 1) + 1):
        out[:, step:] |= down[:, :-step]
        out[:, :-step] |= down[:, step:]
    return out

"""Cut polygons and strips into triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import cross

Integers = NDArray[np.int64]


def fans(sizes: Integers, corners: Integers) -> Integers:
    """Cut polygons into triangles from their first corner; those with fewer than three corners are dropped.

    Parameters
    ----------
    sizes : (P,) int64
        Number of corners of each polygon.
    corners : (sum of sizes,) int64
        Vertex indices of the corners, polygon by polygon.

    Returns
    -------
    (M, 3) int64

    Examples
    --------
    >>> fans(np.array([3, 2, 4]), np.array([0, 1, 2, 7, 8, 3, 4, 5, 6])).tolist()
    [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    """
    if (sizes == 3).all():
        return corners.reshape(-1, 3)
    first = np.cumsum(sizes) - sizes
    made = np.maximum(sizes - 2, 0)
    start = np.repeat(first, made)
    step = np.arange(len(start)) - np.repeat(np.cumsum(made) - made, made)
    return np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)


def recut(vertices: Float64, triangles: Integers, made: Integers) -> Integers:
    """Cut concave polygons again, so that their triangles stay inside them and do not overlap.

    Parameters
    ----------
    vertices : (N, 3) float64
    triangles : (M, 3) int64
        As returned by `fans`.
    made : (P,) int64
        Number of triangles of each polygon, M in total; or empty if there are no polygons.

    Returns
    -------
    (M, 3) int64
    """
    if not (made > 1).any():
        return triangles
    begin = (np.cumsum(made) - made)[made > 0]
    count = made[made > 0]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    with np.errstate(invalid="ignore", over="ignore"):  # vertices may still be NaN or infinite
        twice = cross(b - a, c - a)
        whole = np.add.reduceat(twice, begin)
        along = np.einsum("ij,ij->i", twice, np.repeat(whole, count, axis=0))
    bent = np.flatnonzero((count > 1) & (np.minimum.reduceat(along, begin) < 0))
    out = triangles.copy()
    for polygon in bent:
        rows = slice(int(begin[polygon]), int(begin[polygon] + count[polygon]))
        fan = triangles[rows]
        corners = np.concatenate([fan[0, :2], fan[:, 2]])
        again = _cut(vertices[corners], whole[polygon])
        if len(again) == len(fan):  # not if the polygon crosses itself
            out[rows] = corners[again]
    return out


def _cut(points: Float64, normal: Float64) -> Integers:
    """Cut a polygon, projected along its normal, into (n - 2, 3) triangles with its winding."""
    import mapbox_earcut

    axis = int(np.abs(normal).argmax())
    flat = np.delete(points, axis, axis=1)
    if not np.isfinite(flat).all():
        return np.zeros((0, 3), np.int64)
    found = mapbox_earcut.triangulate_float64(flat, np.array([len(flat)], np.uint32)).reshape(-1, 3).astype(np.int64)
    if len(found):
        a, b, c = (points[found[:, k]] for k in range(3))
        if cross(b - a, c - a).sum(axis=0) @ normal < 0:
            found = found[:, ::-1]
    return np.asarray(found)


def strips(sizes: Integers, corners: Integers) -> Integers:
    """Cut strips into triangles, every other one reversed so that all face the same way; -1 begins a new strip.

    Triangles with a repeated vertex only connect strips and are dropped.

    Parameters
    ----------
    sizes : (S,) int64
        Number of entries of each strip.
    corners : (sum of sizes,) int64

    Returns
    -------
    (M, 3) int64

    Examples
    --------
    >>> strips(np.array([7]), np.array([0, 1, 2, 3, -1, 4, 5])).tolist()
    [[0, 1, 2], [2, 1, 3]]
    """
    ends = np.cumsum(sizes)
    marked = np.insert(corners, ends, -1)
    place = np.arange(len(marked))
    # position of an entry in its strip, counted from the last mark before it
    since = place - np.maximum.accumulate(np.where(marked < 0, place, -1)) - 1
    third = np.flatnonzero((since >= 2) & (marked >= 0))
    a, b, c = marked[third - 2], marked[third - 1], marked[third]
    odd = since[third] % 2 == 1
    triangles = np.stack([np.where(odd, b, a), np.where(odd, a, b), c], axis=1)
    return np.asarray(triangles[(a != b) & (b != c) & (a != c)])


def one_strip(corners: Integers) -> Integers:
    """Cut one strip of a glTF into triangles, every other one reversed; those without area are kept.

    Parameters
    ----------
    corners : (N,) int64

    Returns
    -------
    (N - 2, 3) int64

    Examples
    --------
    >>> one_strip(np.array([0, 1, 2, 3])).tolist()
    [[0, 1, 2], [3, 2, 1]]
    """
    triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    triangles[1::2] = triangles[1::2, ::-1].copy()
    return triangles


def one_fan(corners: Integers) -> Integers:
    """Cut one fan of a glTF into triangles around its first corner; those without area are kept.

    Parameters
    ----------
    corners : (N,) int64

    Returns
    -------
    (N - 2, 3) int64

    Examples
    --------
    >>> one_fan(np.array([5, 6, 7, 8])).tolist()
    [[5, 6, 7], [5, 7, 8]]
    """
    return np.stack([np.full(max(len(corners) - 2, 0), corners[0]), corners[1:-1], corners[2:]], axis=1)

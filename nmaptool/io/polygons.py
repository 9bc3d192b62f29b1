"""Polygons and strips cut into triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]


def fans(sizes: Integers, corners: Integers) -> Integers:
    """Triangles of polygons, each cut from its first corner; what has fewer than three corners is left out.

    Parameters
    ----------
    sizes : (P,) int64
        Corners of each polygon.
    corners : (sum of sizes,) int64
        Their vertices, one polygon after the other.

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


def strips(sizes: Integers, corners: Integers) -> Integers:
    """Triangles of strips, every other one turned so that all face one way; -1 begins a new strip.

    Triangles that name a vertex twice only join strips, and are left out.

    Parameters
    ----------
    sizes : (S,) int64
        Entries of each strip.
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
    # place of an entry in its strip: counted from the last mark before it
    since = place - np.maximum.accumulate(np.where(marked < 0, place, -1)) - 1
    third = np.flatnonzero((since >= 2) & (marked >= 0))
    a, b, c = marked[third - 2], marked[third - 1], marked[third]
    odd = since[third] % 2 == 1
    triangles = np.stack([np.where(odd, b, a), np.where(odd, a, b), c], axis=1)
    return np.asarray(triangles[(a != b) & (b != c) & (a != c)])

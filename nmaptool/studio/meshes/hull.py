"""The convex hull of a mesh, which alone frames every view of it."""

from __future__ import annotations

import contextlib

import numpy as np

from nmaptool.core.arrays import Float64

# thickness of a plane, as a share of its size
_FLAT = 1e-9
# on a round mesh nearly every vertex is a corner, and Qhull is slow: if it has many vertices, and this share of a
# sample are corners of the sample, only the outermost vertex in each of many directions is looked at
_MANY, _SAMPLE, _ROUND = 100_000, 5_000, 0.3
# directions along an edge of a cube around the mesh
_DIRECTIONS = 64


def hull(points: Float64) -> Float64:
    """Return the corners of the convex hull of (N, 3) points.

    Seen from any side, they are as large as all points; for round meshes of very many vertices, at most 0.1% smaller.
    What Qhull cannot handle is returned as it is.
    """
    if len(points) > _MANY:
        sample = points[:: len(points) // _SAMPLE]
        if len(_corners(sample)) > _ROUND * len(sample):
            points = _outermost(points)
    return _corners(points)


def _corners(points: Float64) -> Float64:
    from scipy.spatial import ConvexHull, QhullError

    for shown in (points, _in_plane(points)):
        if shown is not None:
            with contextlib.suppress(QhullError):
                return np.asarray(points[np.sort(ConvexHull(shown).vertices)])
    return points


def _in_plane(points: Float64) -> Float64 | None:
    """Return coordinates in the plane of the points; None if they do not lie in one."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    turned = centred @ axes
    return turned[:, 1:] if np.ptp(turned[:, 0]) < _FLAT * np.ptp(turned[:, 2]) else None


def _outermost(points: Float64) -> Float64:
    """Return the outermost point in each direction from the middle; directions are cells of the sides of a cube."""
    low, high = points.min(axis=0), points.max(axis=0)
    around = (points - (low + high) / 2) / np.where(high > low, high - low, 1)
    reach = np.abs(around).max(axis=1)
    side = np.abs(around).argmax(axis=1)
    place = np.floor((around / np.where(reach > 0, reach, 1)[:, None] + 1) * (_DIRECTIONS / 2 - 1e-9)).astype(np.int64)
    cell = ((side * _DIRECTIONS + place[:, 0]) * _DIRECTIONS + place[:, 1]) * _DIRECTIONS + place[:, 2]
    order = np.lexsort((np.einsum("ij,ij->i", around, around), cell))
    last = np.r_[cell[order][1:] != cell[order][:-1], True]
    extremes = np.concatenate([points.argmin(axis=0), points.argmax(axis=0)])
    return np.asarray(points[np.union1d(order[last], extremes)])

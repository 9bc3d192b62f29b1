"""Exact distances from points to triangles, and the Hausdorff distance between surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Mesh

_POINTS_AT_ONCE = 256
_PAIRS_AT_ONCE = 500_000


def hausdorff(points: Float64, mesh: Mesh) -> tuple[float, int]:
    """The largest distance of any of the points from a surface, exactly, and the index of that point.

    The distance to the nearest vertex of the surface is an upper bound for each point. Points are tested in descending
    order of that bound until it is below the distance found, which for a smoothed mesh takes a few hundred points.

    Parameters
    ----------
    points : (K, 3) float64
    mesh : Mesh
        With at least one face.

    Returns
    -------
    distance, place
        Distance in units of the mesh; index of the point.
    """
    from scipy.spatial import cKDTree

    bound, _ = cKDTree(mesh.vertices).query(points)
    order = np.argsort(-bound)
    triangles = _Triangles(mesh.corners)
    farthest, place = 0.0, int(order[0])
    for begin in range(0, len(order), _POINTS_AT_ONCE):
        some = order[begin : begin + _POINTS_AT_ONCE]
        some = some[bound[some] > farthest]
        if not len(some):
            break
        found = triangles.distances(points[some], bound[some])
        if found.max() > farthest:
            farthest, place = float(found.max()), int(some[found.argmax()])
    return farthest, place


class _Triangles:
    """Triangles grouped by size, with a tree for each group, so that a few large ones do not enlarge all searches."""

    def __init__(self, corners: Float64) -> None:
        from scipy.spatial import cKDTree

        centers = corners.mean(axis=1)
        reach = np.sqrt(((corners - centers[:, None]) ** 2).sum(axis=2).max(axis=1))
        octave = np.ceil(np.log2(np.maximum(reach, 1e-300))).astype(int)
        self._corners = corners
        self._classes = []
        for size in np.unique(octave):
            members = np.flatnonzero(octave == size)
            self._classes.append((members, float(reach[members].max()), cKDTree(centers[members])))

    def distances(self, points: Float64, bound: Float64) -> Float64:
        """(K,) float64: distance of each point from the nearest triangle, at most its bound."""
        best = bound.copy()
        slack = bound * (1 + 1e-9)
        for members, reach, tree in self._classes:
            lists = tree.query_ball_point(points, slack + reach)
            owner = np.repeat(np.arange(len(points)), [len(each) for each in lists])
            near = members[np.concatenate([np.asarray(each, int) for each in lists])]
            for begin in range(0, len(owner), _PAIRS_AT_ONCE):
                part = slice(begin, begin + _PAIRS_AT_ONCE)
                np.minimum.at(best, owner[part], to_triangles(points[owner[part]], self._corners[near[part]]))
        return best


def to_triangles(points: Float64, corners: Float64) -> Float64:
    """(K,) float64: exact distance of each point (K, 3) from its triangle (K, 3, 3).

    Either the foot of the perpendicular lies inside, or the nearest point lies on an edge.
    """
    edges = [_to_segments(points, corners[:, k], corners[:, (k + 1) % 3]) for k in range(3)]
    on_edge = np.minimum.reduce(edges)
    a = corners[:, 0]
    ab, ac, ap = corners[:, 1] - a, corners[:, 2] - a, points - a
    normal = np.cross(ab, ac)
    size2 = _dot(normal, normal)
    safe = np.where(size2 > 0, size2, 1)
    second = _dot(np.cross(ap, ac), normal) / safe
    third = _dot(np.cross(ab, ap), normal) / safe
    inside = (size2 > 0) & (second >= 0) & (third >= 0) & (second + third <= 1)
    return np.where(inside, np.abs(_dot(ap, normal)) / np.sqrt(safe), on_edge)


def _to_segments(points: Float64, start: Float64, end: Float64) -> Float64:
    along = end - start
    length2 = _dot(along, along)
    share = (_dot(points - start, along) / np.where(length2 > 0, length2, 1)).clip(0, 1)
    off = points - start - share[:, None] * along
    return np.asarray(np.sqrt(_dot(off, off)))


def _dot(u: Float64, v: Float64) -> NDArray[np.float64]:
    return np.asarray(np.einsum("ij,ij->i", u, v))

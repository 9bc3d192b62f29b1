"""Polygons with holes to triangles that use every corner of the rings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import found_in
from nmaptool.types.solid import Nodes

# so many passes make narrow strips even; wide ones lie in flat places, where triangles may be pointed
_PASSES, _MOST_PASSES = 24, 400
# smaller differences between angles (their sines) are the rounding of numbers
_ROUNDING = 1e-9


def triangulated(rings: Sequence[Float64], inside: Float64 | None = None, *, unit_mm: float = 1.0) -> Nodes:
    """Triangulate the area inside rings.

    Parameters
    ----------
    rings : sequence of (n, 2) float64
        Outer rings counter-clockwise, holes clockwise. Points may lie on one line.
    inside : (k, 2) float64, optional
        Whole numbers: points away from the rings that become corners of triangles, too. If they are given, edges are
        turned until the triangles are as little pointed as possible (Delaunay).
    unit_mm : float
        Size of the unit of the points, for messages.

    Returns
    -------
    (m, 3) int64
        Rows of the concatenated rings, then of the points inside, counter-clockwise, each of positive area.

    Raises
    ------
    InputError
        If the rings cross or touch.
    """
    import manifold3d  # takes long to load

    points = np.concatenate(rings)
    faces = np.asarray(manifold3d.triangulate(list(rings)), np.int64)
    if inside is not None or (_areas(points, faces) <= 0).any():
        faces = _turned(points, faces)
    bad = np.flatnonzero(_areas(points, faces) <= 0)
    if inside is not None and len(inside) and not len(bad):
        points, faces = _with_points(points, faces, inside)
        bad = np.flatnonzero(_areas(points, faces) <= 0)
    if len(bad) or not len(faces):
        x, y = points[faces[bad[0], 0] if len(bad) else 0] * unit_mm
        raise InputError(
            f"the outline crosses or touches itself near x = {x:.6g} mm, y = {y:.6g} mm; its rings must neither cross "
            "each other nor themselves"
        )
    return faces


def _areas(points: Float64, faces: Nodes) -> Float64:
    """(m,) areas, negative for triangles that run clockwise."""
    a, b, c = (points[faces[:, number]] for number in range(3))
    return _cross(b - a, c - a) / 2


def _cross(first: Float64, second: Float64) -> Float64:
    product: Float64 = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return product


def _turned(points: Float64, faces: Nodes) -> Nodes:
    """The same area with edges turned towards no corner within the circle through a neighbouring triangle."""
    faces = faces.copy()
    for number in range(_MOST_PASSES):
        if number >= _PASSES and (_areas(points, faces) > 0).all():
            break
        first, second = _pairs(faces, len(points))
        a, c = faces.ravel()[first], np.roll(faces, -2, axis=1).ravel()[first]
        b, d = faces.ravel()[second], np.roll(faces, -2, axis=1).ravel()[second]
        at_a, at_b, at_c, at_d = (points[each] for each in (a, b, c, d))
        excess = _excess(at_a - at_c, at_b - at_c, at_b - at_d, at_a - at_d)
        turns = (excess < -_ROUNDING) & (_cross(at_d - at_a, at_c - at_a) > 0) & (_cross(at_b - at_d, at_c - at_d) > 0)
        chosen = np.flatnonzero(turns)
        if not len(chosen):
            break
        chosen = chosen[_apart(first[chosen] // 3, second[chosen] // 3, excess[chosen], len(faces))]
        a, b, c, d = a[chosen], b[chosen], c[chosen], d[chosen]
        faces[first[chosen] // 3] = np.stack([a, d, c], axis=1)
        faces[second[chosen] // 3] = np.stack([d, b, c], axis=1)
    return faces


def _with_points(points: Float64, faces: Nodes, inside: Float64) -> tuple[Float64, Nodes]:
    """Insert points, in each round one into each triangle that has some, and turn edges after each round."""
    count, points = len(points), np.concatenate([points, inside])
    waiting = np.ones(len(inside), bool)
    while waiting.any():
        face, point = _found_in(points, faces, inside, waiting)
        face, first = np.unique(face, return_index=True)
        point, first = np.unique(point[first], return_index=True)
        face = face[first]
        if not len(face):
            return points, faces[:0]  # some points lie outside: the rings cross
        a, b, c = faces[face].T
        p = count + point
        faces[face] = np.stack([a, b, p], axis=1)
        faces = np.concatenate([faces, np.stack([b, c, p], axis=1), np.stack([c, a, p], axis=1)])
        faces = _turned(points, faces)
        waiting[point] = False
    return points, faces


def _found_in(points: Float64, faces: Nodes, inside: Float64, waiting: Mask) -> tuple[Nodes, Nodes]:
    """Triangles and the waiting points in them, pair by pair."""
    corners = points[faces]
    low = np.ceil(corners.min(axis=1) - _ROUNDING).astype(np.int64)
    span = np.maximum(np.floor(corners.max(axis=1) + _ROUNDING).astype(np.int64) - low + 1, 0)
    count = span[:, 0] * span[:, 1]
    face = np.repeat(np.arange(len(faces)), count)
    step = np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count)
    down, across = np.divmod(step, span[face, 0])
    wide = 1 << 31
    places = np.rint(inside[waiting]).astype(np.int64)
    codes = places[:, 1] * wide + places[:, 0]
    order = np.argsort(codes)
    at = found_in(codes[order], (low[face, 1] + down) * wide + low[face, 0] + across)
    face, point = face[at >= 0], np.flatnonzero(waiting)[order[at[at >= 0]]]
    a, b, c = (corners[face, number] for number in range(3))
    p = inside[point]
    within = (_cross(b - a, p - a) >= 0) & (_cross(c - b, p - b) >= 0) & (_cross(a - c, p - c) >= 0)
    return face[within], point[within]


def _pairs(faces: Nodes, count: int) -> tuple[Nodes, Nodes]:
    """The two sides of each inner edge, as ``3 * triangle + corner`` at which the side begins."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    code = np.minimum(start, end) * count + np.maximum(start, end)
    order = np.argsort(code, kind="stable")
    same = code[order[1:]] == code[order[:-1]]
    return order[:-1][same], order[1:][same]


def _excess(u: Float64, v: Float64, s: Float64, t: Float64) -> Float64:
    """Sine of the sum of the angles between u and v and between s and t: negative where they exceed a half turn."""
    sine = _cross(u, v) * _dot(s, t) + _dot(u, v) * _cross(s, t)
    found: Float64 = sine / np.sqrt(_dot(u, u) * _dot(v, v) * _dot(s, s) * _dot(t, t))
    return found


def _dot(first: Float64, second: Float64) -> Float64:
    product: Float64 = first[:, 0] * second[:, 0] + first[:, 1] * second[:, 1]
    return product


def _apart(first: Nodes, second: Nodes, excess: Float64, count: int) -> Nodes:
    """Of pairs of triangles, those that have the greatest excess among all that share a triangle with them."""
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(excess, kind="stable")] = np.arange(len(first))
    best = np.full(count, len(first))
    np.minimum.at(best, first, rank)
    np.minimum.at(best, second, rank)
    return np.flatnonzero((best[first] == rank) & (best[second] == rank))

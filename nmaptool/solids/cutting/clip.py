"""Cut a mesh along planes across x or y; closed meshes stay closed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import found_in
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.types.solid import Nodes

# vertices beside a plane are moved so far away from it, as a share of a pixel: nearer ones would make needles
SNAP_PX = 1 / 256


def split(
    vertices: Float64, faces: Nodes, axis: int, at_mm: float, snap_mm: float, *, is_closed: bool
) -> tuple[Float64, Nodes, Nodes]:
    """Cut a mesh in two at a plane.

    Both sides have the same vertices on the plane. A closed mesh gets the same wall on both sides, an open one none.

    Parameters
    ----------
    vertices : (n, 3) float64
        In mm.
    faces : (m, 3) int64
    axis : int
        0 cuts across x, 1 across y.
    at_mm : float
        Place of the plane on that axis.
    snap_mm : float
        Vertices beside the plane are moved at least so far away from it, and those on it stay.
    is_closed : bool
        Whether the mesh is closed.

    Returns
    -------
    vertices : (n + k, 3) float64
        The same vertices, and new ones on the plane.
    below, above : (i, 3), (j, 3) int64
        Triangles with smaller and with greater coordinates.

    Raises
    ------
    InputError
        If the section touches itself.
    """
    vertices = vertices.copy()
    beside = vertices[:, axis] - at_mm
    side = np.sign(beside).astype(np.int64)
    near = (side != 0) & (np.abs(beside) < snap_mm)
    vertices[near, axis] = at_mm + side[near] * snap_mm
    sides = side[faces]
    crosses = (sides.min(axis=1) < 0) & (sides.max(axis=1) > 0)
    kept = faces[~crosses]
    is_below = _lies_below(vertices, kept, sides[~crosses], axis)
    vertices, cut_below, cut_above = _cut(vertices, faces[crosses], side, axis, at_mm)
    below, above = np.concatenate([kept[is_below], cut_below]), np.concatenate([kept[~is_below], cut_above])
    if not (is_closed and len(below) and len(above)):
        return vertices, below, above
    wall = _wall(vertices, below, axis, at_mm)
    below, above = np.concatenate([below, wall]), np.concatenate([above, wall[:, ::-1]])
    for half in (below, above):
        at = _twice(half, vertices[:, axis] == at_mm)
        if at is not None:
            raise _touching(axis, at_mm, vertices[at])
    return vertices, below, above


def _lies_below(vertices: Float64, faces: Nodes, sides: Nodes, axis: int) -> Mask:
    """Whether triangles that a plane does not cross lie below; those in the plane, whether they face up from it."""
    sums = sides.sum(axis=1)
    below: Mask = sums < 0
    flat = np.flatnonzero(sums == 0)
    a, b, c = (vertices[faces[flat, corner]] for corner in range(3))
    below[flat] = np.cross(b - a, c - a)[:, axis] > 0
    return below


def _cut(vertices: Float64, faces: Nodes, side: Nodes, axis: int, at_mm: float) -> tuple[Float64, Nodes, Nodes]:
    """Cut triangles that cross the plane; new vertices lie where their edges do."""
    pairs = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    pairs = np.sort(pairs[side[pairs[:, 0]] * side[pairs[:, 1]] < 0], axis=1)
    count = len(vertices)
    codes = np.unique(pairs[:, 0] * np.int64(count) + pairs[:, 1])
    first, second = np.divmod(codes, count)
    # from the lower number to the higher, so that both sides of an edge find the same point
    start, end = vertices[first], vertices[second]
    share = (at_mm - start[:, axis]) / (end[:, axis] - start[:, axis])
    new = start + share[:, None] * (end - start)
    new[:, axis] = at_mm

    def between(a: Nodes, b: Nodes) -> Nodes:
        return count + found_in(codes, np.minimum(a, b) * np.int64(count) + np.maximum(a, b))

    # the corner alone on its side comes first; or the corner on the plane
    sides = side[faces]
    touches = (sides == 0).any(axis=1)
    alone = np.where(touches, (sides == 0).argmax(axis=1), (sides * sides.sum(axis=1)[:, None]).argmin(axis=1))
    a, b, c = (faces[np.arange(len(faces)), (alone + corner) % 3] for corner in range(3))
    low, high = [], []
    for chosen, makes in ((touches, _halves), (~touches, _corner)):
        one, other = makes(a[chosen], b[chosen], c[chosen], between)
        is_low = side[b[chosen] if makes is _halves else a[chosen]] < 0
        repeat = (len(one) // max(1, len(is_low)), len(other) // max(1, len(is_low)))
        first_low, second_low = np.tile(is_low, repeat[0]), np.tile(is_low, repeat[1])
        low += [one[first_low], other[~second_low]]
        high += [one[~first_low], other[second_low]]
    return np.concatenate([vertices, new]), np.concatenate(low), np.concatenate(high)


def _halves(a: Nodes, b: Nodes, c: Nodes, between: Callable[[Nodes, Nodes], Nodes]) -> tuple[Nodes, Nodes]:
    """Triangles with corner ``a`` on the plane: the half at ``b`` and the half at ``c``."""
    middle = between(b, c)
    return np.stack([a, b, middle], axis=1), np.stack([a, middle, c], axis=1)


def _corner(a: Nodes, b: Nodes, c: Nodes, between: Callable[[Nodes, Nodes], Nodes]) -> tuple[Nodes, Nodes]:
    """Triangles with corner ``a`` alone on its side: the triangle at ``a``, and the two that are left."""
    p, q = between(a, b), between(c, a)
    rest = np.concatenate([np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)])
    return np.stack([a, p, q], axis=1), rest


def _wall(vertices: Float64, below: Nodes, axis: int, at_mm: float) -> Nodes:
    """The triangles that close the lower side, facing up along the axis."""
    rings = _rings(_open_edges(below, vertices[:, axis] == at_mm)[:, ::-1])
    if not rings:  # the parts only touch
        return np.zeros((0, 3), np.int64)
    # the other two axes such that counter-clockwise faces up along the axis
    plane = vertices[:, [1, 2]] if axis == 0 else vertices[:, [2, 0]]
    numbers = np.concatenate(rings)
    try:
        faces: Nodes = numbers[triangulated([plane[ring] for ring in rings])]
    except InputError:
        raise _touching(axis, at_mm, vertices[numbers[0]]) from None
    return faces


def _touching(axis: int, at_mm: float, near_mm: Float64) -> InputError:
    other = "yx"[axis]
    return InputError(
        f"the plate cannot be cut at {'xy'[axis]} = {at_mm:.6g} mm, where its section touches itself near "
        f"{other} = {near_mm[1 - axis]:.6g} mm; use other parts"
    )


def _twice(faces: Nodes, on_plane: Mask) -> int | None:
    """A vertex of an edge on the plane that is used twice in one direction; None if there is none."""
    start, end = _edges_along(faces, on_plane)
    codes = np.sort(start * np.int64(len(on_plane)) + end)
    twice = np.flatnonzero(codes[1:] == codes[:-1])
    return int(codes[twice[0]] // len(on_plane)) if len(twice) else None


def _open_edges(faces: Nodes, on_plane: Mask) -> Nodes:
    """(k, 2): directed edges on the plane without a triangle on the other side."""
    start, end = _edges_along(faces, on_plane)
    count = np.int64(len(on_plane))
    alone = ~np.isin(start * count + end, end * count + start, kind="sort")
    return np.column_stack([start[alone], end[alone]])


def _edges_along(faces: Nodes, on_plane: Mask) -> tuple[Nodes, Nodes]:
    """Both ends of the directed edges on the plane."""
    ends = np.roll(faces, -1, axis=1)
    along = on_plane[faces] & on_plane[ends]
    return faces[along], ends[along]


def _rings(edges: Nodes) -> list[Nodes]:
    """Directed edges as closed rings of vertices."""
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    left = np.ones(len(edges), bool)
    rings = []
    for first in range(len(edges)):
        at, ring = first, []
        while left[at]:
            left[at] = False
            ring.append(int(edges[at, 0]))
            following = np.searchsorted(edges[:, 0], edges[at, 1])
            while following + 1 < len(edges) and not left[following] and edges[following + 1, 0] == edges[at, 1]:
                following += 1
            at = int(following)
        if ring:
            rings.append(np.array(ring))
    return rings

"""The triangles of a square tile, each split in two at the middle of its longest side, again and again.

Right-angled triangulated irregular networks: P. Lindstrom et al., Real-Time, Continuous Level of Detail Rendering of
Height Fields, SIGGRAPH 1996; W. Evans et al., Right-Triangulated Irregular Networks, Algorithmica 30, 2001.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.solid import Nodes

# legs of the smallest triangles that are looked at as a whole, in px; a tile is at least as wide
UNIT_PX = 8
# units in one product of matrices: so few that BLAS does not start threads, which take longer to start than to compute
_AT_ONCE = 64


@dataclass(frozen=True, eq=False)
class Inner:
    """One level of triangles within every unit.

    Attributes
    ----------
    matrix : (points * triangles, 45) float64
        Takes heights of a unit to how far they lie from the planes of the triangles.
    members : (triangles, 45) float64
        1 where a vertex of the unit lies in a triangle.
    triangles : int
    """

    matrix: Float64
    members: Float64
    triangles: int

    def errors(self, z: Float64) -> Float64:
        """(g, triangles, n) largest deviations in g groups of n units, from (g, 45, n) heights."""
        off = self.matrix @ z
        np.abs(off, out=off)
        largest: Float64 = off.reshape(len(z), -1, self.triangles, z.shape[2]).max(axis=1)
        return largest


@dataclass(frozen=True, eq=False)
class Tree:
    """The triangles of a tile of ``side`` px.

    Attributes
    ----------
    side : int
    units : (g, 45, n) int64
        The vertices ``row * (side + 1) + col`` of each unit, in g groups of n units.
    inner : tuple of Inner
        Levels within units, from the coarsest.
    outer : tuple of ((2, t, 3) int64, (3, p) float)
        Levels of units and above, from the finest: the vertices at the corners of triangles, and the weights of the
        corners at the vertices in the order of ``units``.
    first, second : (m,) int64
        The vertex that splits each triangle: all levels of `inner`, then those of `outer`. The two triangles that a
        vertex splits are one of `first` and one of `second`.
    """

    side: int
    units: Nodes
    inner: tuple[Inner, ...]
    outer: tuple[tuple[Nodes, Float64], ...]
    first: Nodes
    second: Nodes

    def errors(self, z: Float64, known: Mask | None) -> Float64:
        """The largest deviation of heights from the two triangles that each vertex of the tile splits.

        Parameters
        ----------
        z : (side+1, side+1) float64
        known : (side+1, side+1) bool, optional
            Vertices that count; a triangle with one that does not has no error. Default: all.

        Returns
        -------
        (side+1, side+1) float64
            0 at the corners of the tile, which split nothing.
        """
        flat = z.ravel()
        at_units = flat.take(self.units)
        found = [level.errors(at_units) for level in self.inner]
        points = np.ascontiguousarray(at_units.transpose(0, 2, 1))
        for corners, weights in self.outer:
            off = flat.take(corners) @ weights
            off -= points.reshape(off.shape)
            np.abs(off, out=off)
            found.append(off.max(axis=2).reshape(-1, 2, 1))
        if known is not None:
            for each, counts in zip(found, self._counting(known), strict=True):
                each[~counts] = 0
        out = np.zeros_like(flat)
        out[self.first] = np.concatenate([each[:, ::2].ravel() for each in found])
        second = np.concatenate([each[:, 1::2].ravel() for each in found])
        out[self.second] = np.maximum(out[self.second], second)
        return out.reshape(z.shape)

    def _counting(self, known: Mask) -> list[Mask]:
        """Whether all vertices of each triangle count, level by level as in `errors`."""
        at_units = known.ravel()[self.units]
        numbers = at_units.astype(np.float64)
        found = [level.members @ numbers > level.members.sum(axis=1)[:, None] - 0.5 for level in self.inner]
        whole = at_units.all(axis=1).ravel()
        for _ in self.outer:
            found.append(whole.reshape(-1, 2, 1))
            whole = whole[::2] & whole[1::2]
        return found


@lru_cache(maxsize=4)
def tree(side: int) -> Tree:
    """The tree of a tile.

    Parameters
    ----------
    side : int
        A power of two, at least `UNIT_PX`.
    """
    steps = np.array([[0, 0], [side, side], [0, side]]), np.array([[side, side], [0, 0], [side, 0]])
    levels = [np.stack(steps)]
    while len(levels[-1]) < side**2:
        levels.append(_halves(levels[-1]))
    unit_level = len(levels) - 6
    inner, outer = _inner_levels(), []
    units, weights = _lattice(levels[unit_level])
    for corners in levels[unit_level::-1]:
        outer.append(((corners @ [side + 1, 1]).reshape(2, -1, 3), weights))
        weights = _weights_of_parent(weights)
    numbers: Nodes = units @ np.array([side + 1, 1])
    group = min(_AT_ONCE, len(units))
    splits = [(_middles(each) @ [side + 1, 1]) for each in levels]
    inner_splits = [
        each.reshape(-1, group, len(each) // len(units)).swapaxes(1, 2) for each in splits[unit_level + 1 :]
    ]
    in_order = inner_splits + [each.reshape(-1, 2, 1) for each in splits[unit_level::-1]]
    return Tree(
        side,
        numbers.reshape(-1, group, numbers.shape[1]).swapaxes(1, 2),
        tuple(Inner(matrix, members, len(members)) for matrix, members in inner),
        tuple(outer),
        np.concatenate([each[:, ::2].ravel() for each in in_order]),
        np.concatenate([each[:, 1::2].ravel() for each in in_order]),
    )


def _middles(triangles: Nodes) -> Nodes:
    """(n, 2): where triangles are split. Corners are two ends of the longest side, then the right angle."""
    return (triangles[:, 0] + triangles[:, 1]) // 2


def _halves(triangles: Nodes) -> Nodes:
    """(2 n, 3, 2): the two halves of each of (n, 3, 2) triangles, in the same sense of rotation."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    middle = _middles(triangles)
    return np.stack([np.stack([c, a, middle], axis=1), np.stack([b, c, middle], axis=1)], axis=1).reshape(-1, 3, 2)


def _weights_of_parent(weights: Float64) -> Float64:
    """(3, 2 p): weights of a triangle's corners at the points of both halves, from (3, p) those of the halves."""
    a, b, c = weights
    half = c / 2
    return np.concatenate([[b + half, half, a], [half, a + half, b]], axis=1)


def _lattice(units: Nodes) -> tuple[Nodes, Float64]:
    """(n, 45, 2): the vertices in units, and (3, 45): the weights of their corners there."""
    i, j = np.nonzero(np.add.outer(np.arange(UNIT_PX + 1), np.arange(UNIT_PX + 1)) <= UNIT_PX)
    a, b, c = (units[:, number, None] for number in range(3))
    along_a, along_b = (a - c) // UNIT_PX, (b - c) // UNIT_PX
    weights = np.stack([i, j, UNIT_PX - i - j]) / UNIT_PX
    return c + along_a * i[:, None] + along_b * j[:, None], weights


def _inner_levels() -> list[tuple[Float64, Float64]]:
    """The matrix and the members of each level within a unit."""
    unit = np.array([[[UNIT_PX, 0], [0, UNIT_PX], [0, 0]]])
    points = _lattice(unit)[0][0]
    out = []
    triangles = _halves(unit)
    while len(triangles) <= UNIT_PX**2 // 2:
        rows, members = [], []
        for corners in triangles:
            weights = np.linalg.solve(
                np.vstack([corners.T, np.ones(3)]), np.vstack([points.T, np.ones(len(points))])
            )  # (3, 45)
            inside = (weights > -1e-9).all(axis=0)
            others = inside & (weights < 1 - 1e-9).all(axis=0)
            matrix = -np.eye(len(points))
            for corner, weight in zip(corners, weights, strict=True):
                matrix[:, (points == corner).all(axis=1).argmax()] += weight
            rows.append(matrix[others])
            members.append(inside)
        out.append((np.stack(rows, axis=1).reshape(-1, len(points)), np.array(members, np.float64)))
        triangles = _halves(triangles)
    return out

"""A surface with pattern coordinates, and measurements on it, for all training meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Faces = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles, with coordinates ``uv`` along the surface if its form has them; u repeats after ``period``."""

    vertices: Array
    faces: Faces
    uv: Array | None = None
    period: float = 0.0

    @cached_property
    def crosses(self) -> Array:
        """(M, 3): normals of the faces, with lengths of twice their areas."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return np.cross(b - a, c - a)

    @cached_property
    def face_normals(self) -> Array:
        """(M, 3): of unit length."""
        return self.crosses / np.linalg.norm(self.crosses, axis=1, keepdims=True)

    @cached_property
    def thinness(self) -> Array:
        """(M,): height of each face over its longest edge, divided by that edge; at most 0.87."""
        corners = self.vertices[self.faces]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        return np.linalg.norm(self.crosses, axis=1) / longest**2

    @cached_property
    def normals(self) -> Array:
        """(N, 3): vertex normals, the angle-weighted mean of the face normals."""
        total = np.zeros_like(self.vertices)
        for k in range(3):
            here, one, two = (self.vertices[self.faces[:, (k + step) % 3]] for step in range(3))
            a, b = one - here, two - here
            cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
            share = self.face_normals * np.arccos(cosine.clip(-1, 1))[:, None]
            total += summed(self.faces[:, k], share, len(total))
        return total / np.linalg.norm(total, axis=1, keepdims=True).clip(1e-12, None)

    @cached_property
    def edges(self) -> NDArray[np.int64]:
        """(E, 2): vertices of each edge, once, in ascending order."""
        ends = np.sort(np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]]), axis=1)
        return np.unique(ends, axis=0).astype(np.int64)

    @cached_property
    def edge(self) -> float:
        """Mean length of an edge, the unit of everything in the catalogue."""
        first, second = self.edges.T
        return float(np.linalg.norm(self.vertices[first] - self.vertices[second], axis=1).mean())

    def crease_points(self, degrees: float = 18.0) -> Array:
        """Vertices of the edges at which two faces meet at more than an angle."""
        pairs, ends = neighbours(self.faces)
        cosine = (self.face_normals[pairs[:, 0]] * self.face_normals[pairs[:, 1]]).sum(axis=1)
        return self.vertices[np.unique(ends[cosine < np.cos(np.radians(degrees))])]

    def away_from_creases(self, start: float, end: float) -> Array:
        """(N,): 0 within ``start`` edges of a crease, 1 beyond ``end``."""
        points = self.crease_points()
        if not len(points):
            return np.ones(len(self.vertices))
        return smooth_step(cKDTree(points).query(self.vertices)[0] / self.edge, start, end)

    def slopes(self, heights: Array) -> Array:
        """(M,): slope of a height over the surface on each face."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        ha, hb, hc = (heights[self.faces[:, k], None] for k in range(3))
        along = ha * (c - b) + hb * (a - c) + hc * (b - a)
        return np.linalg.norm(along, axis=1) / np.linalg.norm(self.crosses, axis=1)

    def raised(self, heights: Array) -> Array:
        """Vertices moved along their normals."""
        return self.vertices + self.normals * heights[:, None]


def summed(group: NDArray[np.integer], values: Array, count: int) -> Array:
    """(count, K): sums of the rows of values that have the same group."""
    return np.stack([np.bincount(group, column, count) for column in values.T], axis=1)


def neighbours(faces: Faces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(E, 2) pairs of faces that share an edge, and (E, 2) the vertices of that edge."""
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1).astype(np.int64)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner = ends[order], owner[order]
    same = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    return np.stack([owner[same], owner[same + 1]], axis=1), ends[same]


def smooth_step(value: Array, low: float, high: float) -> Array:
    """0 below ``low``, 1 above ``high``, smooth between."""
    t = ((value - low) / (high - low)).clip(0, 1)
    return t * t * (3 - 2 * t)


def angle_deg(one: Array, two: Array) -> Array:
    """Angles between rows of unit vectors, in degrees."""
    return np.degrees(2 * np.arcsin((np.linalg.norm(one - two, axis=1) / 2).clip(0, 1)))

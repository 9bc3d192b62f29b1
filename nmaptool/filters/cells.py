"""Patches of a surface: connected faces in one small cube, so both sides of a thin sheet are in separate patches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces, directed_edges, edge_keys, sum_by

Labels = NDArray[np.int64]


def face_neighbors(faces: Faces) -> tuple[Labels, Labels]:
    """Return the pairs of faces that share an edge; if more than two share an edge, they form a chain of pairs."""
    keys = edge_keys(*directed_edges(faces))
    order = np.argsort(keys, kind="stable")
    same = keys[order[1:]] == keys[order[:-1]]
    return order[:-1][same] % len(faces), order[1:][same] % len(faces)


@dataclass(frozen=True, eq=False)
class ConnectedFaces:
    """The centroids of the faces of a surface, and which faces are adjacent.

    Attributes
    ----------
    centroids : (M, 3) float64
    neighbors : pair of (E,) int64
        Pairs of faces that share an edge.
    """

    centroids: Float64
    neighbors: tuple[Labels, Labels]

    def patches(self, side: float) -> Labels:
        """Return the patch of each face as (M,) int64, from 0; ``side`` is the side length of the cubes."""
        # the cubes are symmetric about the middle, so a mirrored surface has mirrored patches
        middle = (self.centroids.min(axis=0) + self.centroids.max(axis=0)) / 2
        place = np.floor((self.centroids - middle) / side + 0.5).astype(np.int64)
        place -= place.min(axis=0)
        key = (place[:, 0] << 42) + (place[:, 1] << 21) + place[:, 2]
        one, other = self.neighbors
        together = key[one] == key[other]
        return _components(one[together], other[together], len(self.centroids))[1]

    def reach(self, radius: float) -> Reach:
        """Return which patches can be reached along the surface without leaving a ball of this radius.

        The side of the patches is two thirds of ``radius``.
        """
        side = radius / 1.5
        patch = self.patches(side)
        count = int(patch.max()) + 1
        size = np.bincount(patch)
        middle = sum_by(patch, self.centroids, count) / size[:, None]
        one, other = (patch[side_] for side_ in self.neighbors)
        apart = one != other
        one, other = one[apart], other[apart]
        own = np.arange(count)
        step = sparse.csr_array(
            (
                np.ones(2 * len(one) + count, np.bool_),
                (np.concatenate([one, other, own]), np.concatenate([other, one, own])),
            ),
            shape=(count, count),
        )
        step = _within(step, middle, radius + side)
        two = _within(step @ step, middle, radius + side)
        four = _within(two @ two, middle, radius + side)
        return Reach(patch, _within(four @ two, middle, radius + side))


def _components(one: Labels, other: Labels, count: int) -> tuple[int, Labels]:
    graph = sparse.coo_array((np.ones(len(one), np.bool_), (one, other)), shape=(count, count))
    parts, label = connected_components(graph, directed=False)
    return int(parts), label.astype(np.int64)


@dataclass(frozen=True, eq=False)
class Reach:
    """The pairs of patches that can reach each other along the surface.

    Attributes
    ----------
    patch : (M,) int64
        Patch of each face.
    near : (P, P) sparse bool
        Pairs of patches, including each with itself, connected by patches that all lie within the radius of the first.
    """

    patch: Labels
    near: Any

    @cached_property
    def rows(self) -> tuple[Labels, Labels]:
        """The patches that each patch can reach, in compressed rows: (P + 1,) int64 and (N,) int64."""
        return self.near.indptr.astype(np.int64), self.near.indices.astype(np.int64)


def _within(pairs: Any, middle: Float64, radius: float) -> Any:
    """Return the pairs whose centres are within a radius of each other, each once."""
    pairs = pairs.tocoo()
    one, other = pairs.coords
    step = middle[one] - middle[other]
    keep = np.einsum("ij,ij->i", step, step) <= radius * radius
    out = sparse.csr_array((np.ones(int(keep.sum()), np.bool_), (one[keep], other[keep])), shape=pairs.shape)
    out.sum_duplicates()
    out.data[:] = True
    return out

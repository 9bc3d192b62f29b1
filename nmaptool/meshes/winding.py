"""Wind faces consistently: neighbours agree on which side is outside, so their normals can be averaged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.mesh import Faces, directed_edges, edge_keys


def is_consistently_wound(faces: Faces) -> bool:
    """Whether no two faces run along an edge in the same direction, as repeated faces do."""
    first, second = directed_edges(faces)
    keys = first << 32 | second
    keys.sort()
    return not (keys[1:] == keys[:-1]).any()


def duplicate_faces(faces: Faces) -> Mask:
    """(M,) bool: faces with the same three vertices, in any order, as an earlier face."""
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    same = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    out = np.zeros(len(faces), bool)
    out[order[1:][same]] = True  # the sort is stable: the first of each group is kept
    return out


def faces_to_flip(faces: Faces, areas: Float64) -> Mask:
    """The faces to flip so that all faces connected by edges of exactly two faces are wound alike.

    Parameters
    ----------
    faces : (M, 3) int32
    areas : (M,) float64
        In each connected piece, the part with the larger area is kept. Nothing is flipped in a one-sided piece, such as
        a Moebius strip.

    Returns
    -------
    (M,) bool
    """
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    count = len(faces)
    one, other, agree = _pairs(faces)
    # each face has two nodes, as given (f) and flipped (f + count); nodes that agree are connected
    turned = np.where(agree, 0, count)
    rows, cols = np.concatenate([one, one + count]), np.concatenate([other + turned, other + count - turned])
    graph = sparse.coo_array((np.ones(len(rows), bool), (rows, cols)), shape=(2 * count, 2 * count))
    pieces, label = connected_components(graph, directed=False)
    kept, flipped = label[:count], label[count:]
    area = np.bincount(kept, areas, pieces)
    return np.asarray((area[kept] < area[flipped]) | ((area[kept] == area[flipped]) & (kept > flipped)))


def _pairs(faces: Faces) -> tuple[NDArray[np.int64], NDArray[np.int64], Mask]:
    """Pairs of faces that share an edge with no third face, and whether they run along it in opposite directions."""
    first, second = directed_edges(faces)
    keys = edge_keys(first, second)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]]))
    begin = starts[np.diff(np.append(starts, len(keys))) == 2]
    one, other = order[begin], order[begin + 1]
    return one % len(faces), other % len(faces), first[one] == second[other]

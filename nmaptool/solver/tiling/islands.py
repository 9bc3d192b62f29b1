"""Islands that reach across tiles: labels within each tile, merged along the borders."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32

Labels = NDArray[np.int32]


def label_faces(weight: Float32) -> tuple[Labels, int]:
    """(h, w) island of each face with a weight, 0 for none, and their number.

    Faces that share a vertex belong together.

    Parameters
    ----------
    weight : (h, w) float32
        The faces that touch the vertices of a tile: its own, with one row above and one column to the left, if any.
    """
    acting = weight > 0
    if acting.all():
        return np.ones(weight.shape, np.int32), 1
    import cv2

    count, labels = cv2.connectedComponents(acting.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    return np.asarray(labels, np.int32), count - 1


def label_vertices(faces: Labels) -> Labels:
    """(h+1, w+1) island of each vertex at the corners of faces."""
    rows, cols = faces.shape
    out = np.zeros((rows + 1, cols + 1), np.int32)
    for corner in (out[:-1, :-1], out[:-1, 1:], out[1:, :-1], out[1:, 1:]):
        np.maximum(corner, faces, out=corner)
    return out


def merge(counts: Sequence[int], pairs: Sequence[tuple[int, Labels, int, Labels]]) -> tuple[list[Labels], int]:
    """Merge the islands of tiles.

    Parameters
    ----------
    counts : sequence of int
        Number of islands in each tile.
    pairs : sequence of (first, labels, second, labels)
        Labels of the same faces in two tiles.

    Returns
    -------
    numbers : list of (count+1,) int32
        For each tile, the number of each of its islands among all; 0 for none.
    count : int
    """
    from scipy import sparse  # takes long to load

    starts = np.concatenate([[0], np.cumsum(counts)])
    firsts, seconds = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for first, here, second, there in pairs:
        both = np.unique(np.column_stack([here, there]), axis=0)
        both = both[(both > 0).all(axis=1)]
        firsts.append(starts[first] + both[:, 0] - 1)
        seconds.append(starts[second] + both[:, 1] - 1)
    a, b = np.concatenate(firsts), np.concatenate(seconds)
    total = int(starts[-1])
    graph = sparse.coo_matrix((np.ones(len(a), np.int8), (a, b)), (total, total))
    count, found = sparse.csgraph.connected_components(graph, directed=False)
    numbers = [
        np.concatenate([[0], found[start:stop] + 1]).astype(np.int32) for start, stop in itertools.pairwise(starts)
    ]
    return numbers, int(count) if total else 0

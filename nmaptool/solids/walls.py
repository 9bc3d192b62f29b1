"""Walls between the outline of a front and the same outline on the back."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.solid import Nodes, Part

_BAND_EDGES = 1 << 17


def wall_parts(
    start: Nodes,
    end: Nodes,
    front: Callable[[Nodes], Float64],
    back: Callable[[Nodes], Float64],
    back_offset: int,
) -> Iterator[Part]:
    """Two triangles for each edge of an outline, facing away from the body.

    Parameters
    ----------
    start, end : (n,) int64
        Nodes of the directed edges, with the body to the left.
    front, back : callable
        (k, 3) float64 mm of nodes on the front, and of those below them on the back.
    back_offset : int
        Number of a node on the back less that on the front.

    Yields
    ------
    Part
    """
    for first in range(0, len(start), _BAND_EDGES):
        pair = np.stack([start[first : first + _BAND_EDGES], end[first : first + _BAND_EDGES]], axis=1)
        nodes, local = np.unique(pair, return_inverse=True)
        a, b = local.reshape(-1, 2).astype(np.int32).T
        below_a, below_b = a + np.int32(len(nodes)), b + np.int32(len(nodes))
        faces = np.stack([b, a, below_a, b, below_a, below_b], axis=1).reshape(-1, 3)
        xyz_mm = np.concatenate([front(nodes), back(nodes)])
        yield Part(xyz_mm, faces, np.concatenate([nodes, nodes + back_offset]))

"""Find the boundary of an open mesh."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.types.mesh import Faces, directed_edges, edge_keys


def boundary_vertices(faces: Faces, count: int) -> Mask:
    """Return (N,) bool: vertices of the edges that belong to only one face."""
    first, second = directed_edges(faces)
    _, place, times = np.unique(edge_keys(first, second), return_index=True, return_counts=True)
    single = place[times == 1]
    out = np.zeros(count, bool)
    out[first[single]] = True
    out[second[single]] = True
    return out

"""Unfold faces that are folded over: their projections would stay folded, and the energy does not penalise that."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.reconstruction.stitching import assembled, direct
from nmaptool.types.mesh import Faces

# a connected part of the mesh that is folded entirely has no neighbours that fix its position
_TIE = 1e-3


def relaxed(vertices: Float64, faces: Faces, folded: Mask, held: Mask) -> Float64:
    """Return the vertices with those of folded faces distributed evenly between their neighbours; all others stay.

    Minimises sum |R x|^2 over these vertices, R = I - 1/3: such a membrane has no folds if its outline is convex.

    Parameters
    ----------
    vertices : (N, 3) float64
    faces : (M, 3) int32
    folded : (M,) bool
    held : (N,) bool
        Vertices that are never moved.
    """
    loose = np.zeros(len(vertices), bool)
    loose[faces[folded]] = True
    loose &= ~held
    chosen = np.flatnonzero(loose)
    if not len(chosen):
        return vertices
    around = faces[loose.take(faces).any(axis=1)]
    used, local = np.unique(around, return_inverse=True)
    patch = local.reshape(-1, 3).astype(np.int32)
    inner = loose[used]
    tie = np.where(inner, _TIE, 0.0)
    matrix = assembled(patch, np.broadcast_to(np.eye(3) - 1 / 3, (len(patch), 3, 3)), tie)[inner]
    start = vertices.take(used, axis=0)
    load = tie[inner][:, None] * start[inner] - matrix[:, ~inner] @ start[~inner]
    out = vertices.copy()
    out[chosen] = direct(matrix[:, inner])(load)
    return out

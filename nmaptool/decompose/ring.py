"""Faces that share a vertex: the neighbourhood that the paper prints (Sec. 3.1, Eq. 1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from nmaptool.arrays import Float32, Float64
from nmaptool.decompose.rolling import Gather
from nmaptool.mesh import FaceGeometry, Faces, Mesh

# rows of the pair list that are weighted at a time
_PAIRS_AT_ONCE = 4_000_000


def neighbor_pairs(faces: Faces, vertex_count: int) -> sparse.csr_array:
    """(M, M) pattern of faces that share at least one vertex, each face with itself included."""
    count = len(faces)
    incidence = sparse.csr_array(
        (np.ones(3 * count, np.int8), faces.ravel(), np.arange(0, 3 * count + 1, 3, dtype=np.int32)),
        shape=(count, vertex_count),
    )
    return incidence @ incidence.T.tocsr()


def gather_ring(mesh: Mesh, geometry: FaceGeometry, sigma_s: float, sigma_r: float) -> Gather:
    """Sums over the ring of each face.

    Parameters
    ----------
    mesh : Mesh
        Clean and welded.
    geometry : FaceGeometry
    sigma_s : float
        In units of the mesh.
    sigma_r : float
        Of differences of unit normals.
    """
    pattern: Any = neighbor_pairs(mesh.faces, len(mesh.vertices))
    start, other = pattern.indptr, pattern.indices
    middle = (geometry.centroids.min(axis=0) + geometry.centroids.max(axis=0)) / 2
    where = ((geometry.centroids - middle) / sigma_s).astype(np.float32)
    weighted = (geometry.normals * (geometry.areas / geometry.areas.max())[:, None]).astype(np.float32)
    near = _kernel(where, start, other, 1.0)

    def gather(guide: Float64 | None) -> Float64:
        weights = near
        if guide is not None:
            weights = near * _kernel(guide.astype(np.float32), start, other, sigma_r)
        matrix = sparse.csr_array((weights, other, start), shape=pattern.shape)
        return np.asarray(matrix @ weighted, np.float64)

    return gather


def _kernel(values: Float32, start: Any, other: Any, sigma: float) -> Float32:
    """exp(-|v_i - v_j|^2 / 2 sigma^2) for each pair."""
    out = np.empty(len(other), np.float32)
    rows = len(start) - 1
    scale = np.float32(-0.5 / sigma**2)
    first = 0
    while first < rows:
        last = max(int(np.searchsorted(start, start[first] + _PAIRS_AT_ONCE, side="right")) - 1, first + 1)
        pairs = slice(start[first], start[last])
        step = np.repeat(values[first:last], np.diff(start[first : last + 1]), axis=0)
        step -= values[other[pairs]]
        distance2 = np.einsum("ij,ij->i", step, step)
        np.exp(np.multiply(distance2, scale, out=distance2), out=out[pairs])
        first = last
    return out

"""Faces that share a vertex: the neighbourhood as printed in the paper (Sec. 3.1, Eq. 1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from nmaptool.core.arrays import Float32, Float64
from nmaptool.filters.rolling import Gather, weighted_normals
from nmaptool.types.mesh import Faces, Mesh

# pairs per batch
_PAIRS_AT_ONCE = 500_000


def neighbor_pairs(faces: Faces, vertex_count: int) -> sparse.csr_array:
    """Return the (M, M) pattern of faces that share at least one vertex, including each face with itself."""
    count = len(faces)
    incidence = sparse.csr_array(
        (np.ones(3 * count, np.int8), faces.ravel(), np.arange(0, 3 * count + 1, 3, dtype=np.int32)),
        shape=(count, vertex_count),
    )
    return incidence @ incidence.T.tocsr()


def gather_ring(mesh: Mesh, sigma_s: float, sigma_r: float) -> Gather:
    """Return a function that sums over the ring of each face; a `GatherMaker`."""
    geometry = mesh.geometry
    start, other = _pairs_once(neighbor_pairs(mesh.faces, len(mesh.vertices)))
    middle = (geometry.centroids.min(axis=0) + geometry.centroids.max(axis=0)) / 2
    where = ((geometry.centroids - middle) / sigma_s).astype(np.float32)
    weighted = weighted_normals(geometry.normals, geometry.areas).astype(np.float32)
    near = _kernel(where, start, other, 1.0)

    def gather(guide: Float64 | None) -> Float64:
        weights = near
        if guide is not None:
            weights = near * _kernel(guide.astype(np.float32), start, other, sigma_r)
        # a pair has the same weight in both directions, and a face with itself has weight 1
        matrix = sparse.csr_array((weights, other, start), shape=(len(weighted), len(weighted)))
        return np.asarray(matrix @ weighted + matrix.T @ weighted + weighted, np.float64)

    return gather


def _pairs_once(pattern: Any) -> tuple[Any, Any]:
    """Return row starts and columns of the pairs of a symmetric pattern whose second index is the larger one."""
    count = pattern.shape[0]
    later = pattern.indices > np.repeat(np.arange(count, dtype=pattern.indices.dtype), np.diff(pattern.indptr))
    start = np.concatenate([[0], np.cumsum(later, dtype=pattern.indptr.dtype)])[pattern.indptr]
    return start.astype(pattern.indptr.dtype), pattern.indices[later]


def _kernel(values: Float32, start: Any, other: Any, sigma: float) -> Float32:
    """Return exp(-|v_i - v_j|^2 / 2 sigma^2) for each pair."""
    out = np.empty(len(other), np.float32)
    rows = len(start) - 1
    scale = np.float32(-0.5 / sigma**2)
    first = 0
    while first < rows:
        last = max(int(np.searchsorted(start, start[first] + _PAIRS_AT_ONCE, side="right")) - 1, first + 1)
        pairs = slice(start[first], start[last])
        step = np.repeat(values[first:last], np.diff(start[first : last + 1]), axis=0)
        step -= values.take(other[pairs], axis=0)
        distance2 = np.einsum("ij,ij->i", step, step)
        np.exp(np.multiply(distance2, scale, out=distance2), out=out[pairs])
        first = last
    return out

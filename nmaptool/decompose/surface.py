"""Faces within 2.5 sigma_s along the surface, approximated by patches: close to linear in the number of faces.

Rolling guidance (paper, Eq. 1) averages some pi (2.5 sigma_s)^2 of surface around every face: thousands of faces each.
Here faces are gathered into patches, a fraction of sigma_s large, which are split where the guide's normals differ by a
fraction of sigma_r. Patches are weighted in pairs, by the distance of their middles and of their mean guides; between
the middles the sums follow their first derivatives. Tests state the error against the exact sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.arrays import Float32, Float64
from nmaptool.decompose.cells import Labels, Reach, face_neighbors, patches, reach
from nmaptool.decompose.rolling import Gather
from nmaptool.mesh import FaceGeometry, Mesh

RADIUS = 2.5  # sigma_s
_PATCH = 0.5  # sigma_s
_ALIKE = 0.5  # sigma_r


def gather_surface(mesh: Mesh, geometry: FaceGeometry, sigma_s: float, sigma_r: float) -> Gather:
    """Sums over the faces that are reached along the surface within 2.5 sigma_s.

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
    neighbors = face_neighbors(mesh.faces)
    around = reach(geometry.centroids, neighbors, RADIUS * sigma_s)
    patch = patches(geometry.centroids, neighbors, _PATCH * sigma_s)
    middle = (geometry.centroids.min(axis=0) + geometry.centroids.max(axis=0)) / 2
    where = (geometry.centroids - middle) / sigma_s
    areas = geometry.areas / geometry.areas.mean()

    def gather(guide: Float64 | None) -> Float64:
        lead = np.zeros_like(where) if guide is None else guide / sigma_r
        nodes = _nodes(patch, around.patch, where, lead, areas, geometry.normals)
        sums = _pair_sums(nodes, around)
        return _at_faces(nodes, sums, where, lead)

    return gather


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Patches split by their guide, ordered by the large patch they lie in.

    Attributes
    ----------
    of_face : (M,) int64
    large : (K,) int64
        The patch of `Reach` that each lies in.
    places : (K, 6) float32
        Mean position over sigma_s, mean guide over sigma_r.
    normals : (K, 3) float32
        Sum of area times original normal.
    """

    of_face: Labels
    large: Labels
    places: Float32
    normals: Float32


def _nodes(patch: Labels, large: Labels, where: Float64, lead: Float64, areas: Float64, normals: Float64) -> _Nodes:
    # bins are counted from the patch's own first face, so that a smooth patch is rarely cut
    first = np.full(int(patch.max()) + 1, -1)
    first[patch[::-1]] = np.arange(len(patch))[::-1]
    bins = np.floor((lead - lead[first[patch]]) / _ALIKE + 0.5).astype(np.int64)
    bins -= bins.min(axis=0)
    spans = bins.max(axis=0) + 1
    likeness = (bins[:, 0] * spans[1] + bins[:, 1]) * spans[2] + bins[:, 2]
    _, kind = np.unique(likeness, return_inverse=True)
    kinds = int(kind.max()) + 1
    pieces = int(patch.max()) + 1
    # large patches do not hold small ones exactly: a small one that crosses their border counts once in each
    key = (large * pieces + patch) * kinds + kind
    _, of_face = np.unique(key, return_inverse=True)
    count = int(of_face.max()) + 1
    parent = np.empty(count, np.int64)
    parent[of_face] = large

    def total(values: Float64) -> Float64:
        return np.column_stack([np.bincount(of_face, areas * values[:, k], count) for k in range(values.shape[1])])

    mass = np.bincount(of_face, areas, count)[:, None]
    places = np.hstack([total(where), total(lead)]) / mass
    return _Nodes(of_face, parent, places.astype(np.float32), total(normals).astype(np.float32))


def _pair_sums(nodes: _Nodes, around: Reach) -> Float32:
    """(K, 21) float32: at each node the weighted sum of normals (3) and its first moments in place and guide (18)."""
    count = len(nodes.large)
    moments = np.hstack([nodes.normals, (nodes.normals[:, :, None] * nodes.places[:, None, :]).reshape(count, 18)])
    start = np.searchsorted(nodes.large, np.arange(around.near.shape[0] + 1))
    sources, first = _sources(start, around)
    out = np.empty((count, 21), np.float32)
    for large in range(len(start) - 1):
        # the nodes of one large patch have the same sources, so that their weights are a dense block
        mine = slice(start[large], start[large + 1])
        others = sources[first[large] : first[large + 1]]
        center = nodes.places[mine.start]
        weights = _weights(nodes.places[mine] - center, nodes.places[others] - center)
        np.matmul(weights, moments[others], out=out[mine])
    return out


def _sources(start: Labels, around: Reach) -> tuple[Labels, Labels]:
    """The nodes that each large patch reaches, one list after the other, and where each list begins."""
    indptr, near = around.near.indptr, around.near.indices
    size = np.diff(start)[near]
    ends = np.cumsum(size)
    offset = np.repeat(start[near] - (ends - size), size)
    return np.arange(len(offset)) + offset, np.concatenate([[0], ends])[indptr]


def _weights(targets: Float32, sources: Float32) -> Float32:
    """(T, S) float32: both Gaussians at once, 0 beyond the radius; each row up to a factor of its own."""
    squares = np.square(sources) * np.float32(-0.5)
    inside = targets[:, :3] @ sources[:, :3].T
    inside += squares[:, :3].sum(axis=1)
    weights = targets[:, 3:] @ sources[:, 3:].T
    weights += squares[:, 3:].sum(axis=1)
    weights -= np.square(targets[:, 3:]).sum(axis=1)[:, None] * np.float32(0.5)  # or a small sigma_r overflows
    weights += inside
    np.exp(weights, out=weights)
    near = np.square(targets[:, :3]).sum(axis=1) * np.float32(0.5) - np.float32(0.5 * RADIUS**2)
    weights *= inside >= near[:, None]
    return weights


def _at_faces(nodes: _Nodes, sums: Float32, where: Float64, lead: Float64) -> Float64:
    """Sums at the faces, from those at their nodes: for small steps u the weights change by exp(u . (source - node)).

    The factor exp(-|u|^2 / 2) is left out: it is the same for all of a face's sources, and only directions matter.
    """
    value = sums[:, :3].astype(np.float64)
    slope = sums[:, 3:].reshape(-1, 3, 6) - value[:, :, None] * nodes.places[:, None, :]
    step = np.hstack([where, lead]) - nodes.places[nodes.of_face]
    return np.asarray(value[nodes.of_face] + np.einsum("ijk,ik->ij", slope[nodes.of_face], step))

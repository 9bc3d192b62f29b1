"""Faces within 2.5 sigma_s along the surface, approximated by patches: close to linear in the number of faces.

Rolling guidance (paper, Eq. 1) averages some pi (2.5 sigma_s)^2 of surface around every face: thousands of faces each.
Here faces are gathered into patches, a fraction of sigma_s large, which are split where the guide's normals differ by a
fraction of sigma_r. Patches are weighted in pairs, by the distance of their middles and of their mean guides; between
the middles the sums follow their first derivatives. Tests state the error against the exact sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.filters.cells import ConnectedFaces, Labels, Reach, face_neighbors
from nmaptool.filters.principal import principal_axes
from nmaptool.filters.rolling import Gather, weighted_normals
from nmaptool.types.mesh import Mesh, sum_by

RADIUS = 2.5  # sigma_s
_PATCH = 0.48  # sigma_s
_COARSEST, _COARSER = 4.0, 1.3  # sigma_r, and how much coarser at a time
_WEIGHTS_AT_ONCE = 100_000
_ROUNDING = 1e-9  # of the longest side
# from the squares of eight columns to -|place|^2 / 2 and -|guide|^2 / 2
_HALVES = np.repeat(np.eye(3, 2, dtype=np.float32), (3, 3, 2), axis=0) * np.float32(-0.5)


@dataclass(frozen=True)
class Roughness:
    """How roughly sums are worked out.

    Parameters
    ----------
    alike : float
        Patches are split where the guide differs by this many sigma_r.
    pairs_per_face : float
        Where there would be more pairs of nodes, patches are split less.
    """

    alike: float
    pairs_per_face: float


EXACT = Roughness(0.5, np.inf)


class Neighborhood:
    """What can be reached from every face along the surface within 2.5 sigma_s; one serves many fields of normals.

    Places and normals are taken along the mesh's own axes, so that turning or mirroring the mesh turns or mirrors sums.

    Parameters
    ----------
    mesh, sigma_s
        As for `GatherMaker`.
    """

    def __init__(self, mesh: Mesh, sigma_s: float) -> None:
        geometry = mesh.geometry
        self._axes = principal_axes(geometry)
        # rounded, so that a face on the border of a cell does not change sides with the last bit of a turned mesh
        step = _ROUNDING * float(np.ptp(geometry.centroids, axis=0).max()) or 1.0
        own = geometry.centroids @ self._axes.T
        own = np.round((own - (own.min(axis=0) + own.max(axis=0)) / 2) / step) * step
        connected = ConnectedFaces(own, face_neighbors(mesh.faces))
        around = connected.reach(RADIUS * sigma_s)
        self._around = around
        self._cells = _cells(connected.patches(_PATCH * sigma_s), around.patch)
        self._where = own / sigma_s
        self._areas = geometry.areas

    def gather(self, normals: Float64, sigma_r: float, rough: Roughness = EXACT) -> Gather:
        """Sums of (M, 3) unit normals, led by a guide whose differences count in units of ``sigma_r``."""
        parts = weighted_normals(normals @ self._axes.T, self._areas)

        def sums(guide: Float64 | None) -> Float64:
            lead = np.zeros_like(self._where) if guide is None else guide @ self._axes.T / sigma_r
            nodes = self._few_nodes(lead, parts, rough)
            found = _at_faces(nodes, _pair_sums(nodes, self._around), self._where, lead)
            return np.hstack([found[:, :3] @ self._axes, found[:, 3:]])

        return sums

    def _few_nodes(self, lead: Float64, parts: Float64, rough: Roughness) -> _Nodes:
        """Nodes as fine in the guide as is asked for, or coarser where their pairs would be too many."""
        alike = rough.alike
        while True:
            nodes = _nodes(self._cells, self._around.patch, self._where, lead, parts, alike)
            own, reached = _counts(nodes, self._around)
            if alike >= _COARSEST or own @ reached <= rough.pairs_per_face * len(lead):
                return nodes
            alike *= _COARSER


def gather_surface(mesh: Mesh, sigma_s: float, sigma_r: float) -> Gather:
    """Sums over the faces that are reached along the surface within 2.5 sigma_s; a `GatherMaker`."""
    return Neighborhood(mesh, sigma_s).gather(mesh.geometry.normals, sigma_r)


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
    weighted_normals : (K, 4) float32
        Sum of area times original normal, and of area.
    """

    of_face: Labels
    large: Labels
    places: Float32
    weighted_normals: Float32


@dataclass(frozen=True, eq=False)
class _Cells:
    """Small patches, cut at the borders of the large ones, which do not hold them exactly.

    Attributes
    ----------
    number : (M,) int64
        Of the cell of each face, in the order of the large patches.
    first : (M,) int64
        The first face of the small patch that each face lies in.
    """

    number: Labels
    first: Labels


def _cells(patch: Labels, large: Labels) -> _Cells:
    pieces = int(patch.max()) + 1
    first = np.empty(pieces, np.int64)
    first[patch[::-1]] = np.arange(len(patch))[::-1]
    _, number = np.unique(large * pieces + patch, return_inverse=True)
    return _Cells(number, first[patch])


def _nodes(cells: _Cells, large: Labels, where: Float64, lead: Float64, parts: Float64, alike: float) -> _Nodes:
    # bins are counted from the patch's own first face, so that a smooth patch is rarely cut
    bins = np.floor((lead - lead.take(cells.first, axis=0)) / alike + 0.5).astype(np.int64)
    bins -= bins.min(axis=0)
    spans = bins.max(axis=0) + 1
    likeness = (bins[:, 0] * spans[1] + bins[:, 1]) * spans[2] + bins[:, 2]
    _, of_face = np.unique(cells.number * spans.prod() + likeness, return_inverse=True)
    count = int(of_face.max()) + 1
    parent = np.empty(count, np.int64)
    parent[of_face] = large

    sums = sum_by(of_face, parts, count)
    places = sum_by(of_face, np.hstack([where, lead]) * parts[:, 3:], count) / sums[:, 3:]
    return _Nodes(of_face, parent, places.astype(np.float32), sums.astype(np.float32))


def _pair_sums(nodes: _Nodes, around: Reach) -> Float32:
    """(K, 28) float32: at each node the weighted sums (4), and their first moments in place and guide (24)."""
    count = len(nodes.large)
    moments = np.empty((count + 1, 28), np.float32)
    moments[:count, :4] = nodes.weighted_normals
    moments[:count, 4:] = (nodes.weighted_normals[:, :, None] * nodes.places[:, None, :]).reshape(count, 24)
    moments[count] = 0  # a node that adds nothing, to fill up shorter lists of sources
    places = np.zeros((count + 1, 8), np.float32)
    places[:count, :6] = nodes.places
    own, reached = _counts(nodes, around)
    start = np.concatenate([[0], np.cumsum(own)])
    out = np.empty((count, 28), np.float32)
    for large in _batches(own, reached):
        # the nodes of one large patch have the same sources, so that their weights are a dense block
        mine = start[large][:, None] + np.arange(own[large[0]])
        others = _sources(start, around, large, reached[large], count)
        sources = places.take(others, axis=0)
        sources -= places.take(mine[:, :1], axis=0)
        weights = _weights(places.take(mine, axis=0) - places.take(mine[:, :1], axis=0), sources)
        out[mine] = weights @ moments.take(others, axis=0)
    return out


def _counts(nodes: _Nodes, around: Reach) -> tuple[Labels, Labels]:
    """(P,) int64 each: nodes of each large patch, and nodes that it reaches."""
    own = np.bincount(nodes.large, minlength=around.near.shape[0])
    return own, np.asarray(around.near @ own, np.int64)


def _batches(own: Labels, reached: Labels) -> Iterator[Labels]:
    """Large patches with as many nodes each and nearly as many sources, as many at a time as stay in the cache."""
    order = np.lexsort([reached, own])
    mine, others = own[order], reached[order]
    first = 0
    while first < len(order):
        last = first + max(1, _WEIGHTS_AT_ONCE // int(mine[first] * others[first]))
        last = min(last, int(np.searchsorted(mine, mine[first], side="right")))
        last = first + int(np.searchsorted(others[first:last], 1.1 * others[first] + 4, side="right"))
        yield order[first:last]
        first = last


def _sources(start: Labels, around: Reach, large: Labels, reached: Labels, filler: int) -> Labels:
    """(B, S) int64: the nodes that each of some large patches reaches; shorter lists are filled up."""
    begin, end = around.near.indptr[large], around.near.indptr[large + 1]
    near = around.near.indices.take(_ranges(begin, end - begin))
    out = np.full((len(large), int(reached.max())), filler)
    out[np.arange(out.shape[1]) < reached[:, None]] = _ranges(start[near], start[near + 1] - start[near])
    return out


def _ranges(begin: Labels, size: Labels) -> Labels:
    """begin[0], begin[0] + 1, ... begin[0] + size[0] - 1, begin[1], ..."""
    ends = np.cumsum(size)
    return np.asarray(np.arange(ends[-1]) + np.repeat(begin - (ends - size), size), np.int64)


def _weights(targets: Float32, sources: Float32) -> Float32:
    """(B, T, S) float32: both Gaussians at once, 0 beyond the radius; each row up to a factor of its own.

    Places and guides in the first six of eight columns; the other two of ``sources`` are overwritten.
    """
    # -|t - s|^2 / 2 = t . s - |s|^2 / 2 - |t|^2 / 2, the first two by one product
    count = targets.shape[1]
    left = np.zeros((len(targets), 2 * count, 8), np.float32)
    left[:, :count, :3], left[:, :count, 6] = targets[..., :3], 1
    left[:, count:, :6], left[:, count:, 6:] = targets[..., :6], 1
    sources[..., 6:] = np.square(sources) @ _HALVES
    product = left @ sources.swapaxes(-1, -2)
    own = np.square(targets) @ _HALVES
    product[:, count:] += own[..., 1:]  # or a small sigma_r overflows
    weights: Float32 = np.exp(product[:, count:])
    weights *= product[:, :count] >= -(own[..., :1] + np.float32(0.5 * RADIUS**2))
    return weights


def _at_faces(nodes: _Nodes, sums: Float32, where: Float64, lead: Float64) -> Float64:
    """Sums at the faces, from those at their nodes: for small steps u the weights change by exp(u . (source - node)).

    The factor exp(-|u|^2 / 2) is left out: it is the same for all of a face's sources, and only directions matter.
    """
    value = sums[:, :4].astype(np.float64)
    slope = sums[:, 4:].reshape(-1, 4, 6) - value[:, :, None] * nodes.places[:, None, :]
    step = np.hstack([where, lead]) - nodes.places.take(nodes.of_face, axis=0)
    return np.asarray(
        value.take(nodes.of_face, axis=0) + np.einsum("ijk,ik->ij", slope.take(nodes.of_face, axis=0), step)
    )

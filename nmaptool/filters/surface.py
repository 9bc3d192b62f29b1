"""Sums over faces within 2.5 sigma_s along the surface, approximated by patches: nearly linear in the number of faces.

Rolling guidance (paper, Eq. 1) averages about pi (2.5 sigma_s)^2 of surface around every face: thousands of faces each.
Here faces are grouped into patches, whose size is a fraction of sigma_s and which are split where the normals of the
guide differ by a fraction of sigma_r. Pairs of patches are weighted by the distances of their centres and of their mean
guides; between the centres, the sums are extrapolated by their first derivatives. Tests state the error of this
approximation.
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
_COARSEST, _COARSER = 4.0, 1.3  # in sigma_r, and the factor of each step
_WEIGHTS_AT_ONCE = 100_000
_ROUNDING = 1e-9  # of the longest side
# maps the squares of eight columns to -|place|^2 / 2 and -|guide|^2 / 2
_HALVES = np.repeat(np.eye(3, 2, dtype=np.float32), (3, 3, 2), axis=0) * np.float32(-0.5)


@dataclass(frozen=True)
class Roughness:
    """How roughly sums are approximated.

    Parameters
    ----------
    alike : float
        Patches are split where the guide differs by this many sigma_r.
    pairs_per_face : float
        Upper limit of the pairs of nodes per face; to keep it, patches are split less.
    """

    alike: float
    pairs_per_face: float


EXACT = Roughness(0.5, np.inf)


class Neighborhood:
    """The faces within 2.5 sigma_s of every face along the surface; it can be used for many fields of normals.

    Positions and normals are relative to the principal axes of the mesh, so rotating or mirroring the mesh rotates or
    mirrors the sums.

    Parameters
    ----------
    mesh, sigma_s
        As for `GatherMaker`.
    """

    def __init__(self, mesh: Mesh, sigma_s: float) -> None:
        geometry = mesh.geometry
        self._axes = principal_axes(geometry)
        # rounded, so that a face on the border of a cell stays on its side when the mesh is rotated
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
        """Return a function that sums (M, 3) unit normals for a guide, whose differences are divided by ``sigma_r``."""
        parts = weighted_normals(normals @ self._axes.T, self._areas)

        def sums(guide: Float64 | None) -> Float64:
            lead = np.zeros_like(self._where) if guide is None else guide @ self._axes.T / sigma_r
            nodes = self._few_nodes(lead, parts, rough)
            found = _at_faces(nodes, _pair_sums(nodes, self._around), self._where, lead)
            return np.hstack([found[:, :3] @ self._axes, found[:, 3:]])

        return sums

    def _few_nodes(self, lead: Float64, parts: Float64, rough: Roughness) -> _Nodes:
        """Return nodes that are as fine in the guide as requested, or coarser if there would be too many pairs."""
        alike = rough.alike
        while True:
            nodes = _nodes(self._cells, self._around.patch, self._where, lead, parts, alike)
            own, reached = _counts(nodes, self._around)
            if alike >= _COARSEST or own @ reached <= rough.pairs_per_face * len(lead):
                return nodes
            alike *= _COARSER


def gather_surface(mesh: Mesh, sigma_s: float, sigma_r: float) -> Gather:
    """Return a function that sums over the faces within 2.5 sigma_s along the surface; a `GatherMaker`."""
    return Neighborhood(mesh, sigma_s).gather(mesh.geometry.normals, sigma_r)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Patches split by their guide, ordered by the large patch that contains them.

    Attributes
    ----------
    of_face : (M,) int64
        Node of each face.
    large : (K,) int64
        The patch of `Reach` that contains each node.
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
    """Small patches, cut at the borders of the large ones.

    Attributes
    ----------
    number : (M,) int64
        Cell of each face, in the order of the large patches.
    first : (M,) int64
        The first face of the small patch of each face.
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
    # bins are relative to the first face of the patch, so a smooth patch is rarely cut
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
    """Return (K, 28) float32: the weighted sums at each node (4), and their first moments in place and guide (24)."""
    count = len(nodes.large)
    moments = np.empty((count + 1, 28), np.float32)
    moments[:count, :4] = nodes.weighted_normals
    moments[:count, 4:] = (nodes.weighted_normals[:, :, None] * nodes.places[:, None, :]).reshape(count, 24)
    moments[count] = 0  # an empty node that pads shorter lists of sources
    places = np.zeros((count + 1, 8), np.float32)
    places[:count, :6] = nodes.places
    own, reached = _counts(nodes, around)
    start = np.concatenate([[0], np.cumsum(own)])
    out = np.empty((count, 28), np.float32)
    for large in _batches(own, reached):
        # the nodes of one large patch have the same sources, so their weights form a dense block
        mine = start[large][:, None] + np.arange(own[large[0]])
        others = _sources(start, around, large, reached[large], count)
        sources = places.take(others, axis=0)
        sources -= places.take(mine[:, :1], axis=0)
        weights = _weights(places.take(mine, axis=0) - places.take(mine[:, :1], axis=0), sources)
        out[mine] = weights @ moments.take(others, axis=0)
    return out


def _counts(nodes: _Nodes, around: Reach) -> tuple[Labels, Labels]:
    """Return (P,) int64 each: the number of nodes in each large patch, and of nodes that it reaches."""
    own = np.bincount(nodes.large, minlength=around.near.shape[0])
    return own, np.asarray(around.near @ own, np.int64)


def _batches(own: Labels, reached: Labels) -> Iterator[Labels]:
    """Yield batches of large patches with equally many nodes and about as many sources; a batch fits the cache."""
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
    """Return (B, S) int64: the nodes that each large patch of a batch reaches; shorter lists are padded."""
    begin, end = around.near.indptr[large], around.near.indptr[large + 1]
    near = around.near.indices.take(_ranges(begin, end - begin))
    out = np.full((len(large), int(reached.max())), filler)
    out[np.arange(out.shape[1]) < reached[:, None]] = _ranges(start[near], start[near + 1] - start[near])
    return out


def _ranges(begin: Labels, size: Labels) -> Labels:
    """Return begin[0], begin[0] + 1, ... begin[0] + size[0] - 1, begin[1], ..."""
    ends = np.cumsum(size)
    return np.asarray(np.arange(ends[-1]) + np.repeat(begin - (ends - size), size), np.int64)


def _weights(targets: Float32, sources: Float32) -> Float32:
    """Return (B, T, S) float32: the product of both Gaussians, 0 beyond the radius; each row up to a constant factor.

    Places and guides are in the first six of eight columns; the other two of ``sources`` are overwritten.
    """
    # -|t - s|^2 / 2 = t . s - |s|^2 / 2 - |t|^2 / 2; one matrix product gives the first two terms
    count = targets.shape[1]
    left = np.zeros((len(targets), 2 * count, 8), np.float32)
    left[:, :count, :3], left[:, :count, 6] = targets[..., :3], 1
    left[:, count:, :6], left[:, count:, 6:] = targets[..., :6], 1
    sources[..., 6:] = np.square(sources) @ _HALVES
    product = left @ sources.swapaxes(-1, -2)
    own = np.square(targets) @ _HALVES
    product[:, count:] += own[..., 1:]  # otherwise a small sigma_r overflows
    weights: Float32 = np.exp(product[:, count:])
    weights *= product[:, :count] >= -(own[..., :1] + np.float32(0.5 * RADIUS**2))
    return weights


def _at_faces(nodes: _Nodes, sums: Float32, where: Float64, lead: Float64) -> Float64:
    """Return the sums at faces from those at nodes: for small steps u, the weights change by exp(u . (source - node)).

    The factor exp(-|u|^2 / 2) is omitted: it is the same for all sources of a face, and only directions matter.
    """
    value = sums[:, :4].astype(np.float64)
    slope = sums[:, 4:].reshape(-1, 4, 6) - value[:, :, None] * nodes.places[:, None, :]
    step = np.hstack([where, lead]) - nodes.places.take(nodes.of_face, axis=0)
    return np.asarray(
        value.take(nodes.of_face, axis=0) + np.einsum("ijk,ik->ij", slope.take(nodes.of_face, axis=0), step)
    )

"""Sums over faces within 2.5 sigma_s along the surface, approximated by patches: nearly linear in the number of faces.

Rolling guidance (paper, Eq. 1) averages about pi (2.5 sigma_s)^2 of surface around every face: thousands of faces each.
Here faces are grouped into patches, whose size is a fraction of sigma_s and which are split where the normals of the
guide differ by a fraction of sigma_r. Pairs of patches are weighted by the distances of their centres and of their mean
guides; between the centres, the sums are extrapolated by their first derivatives. Tests state the error of this
approximation.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from nmaptool import kernels
from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.parallel import for_each_band, map_parallel
from nmaptool.filters.cells import ConnectedFaces, Labels, Reach, face_neighbors
from nmaptool.filters.principal import principal_axes
from nmaptool.filters.rolling import Gather, weighted_normals
from nmaptool.types.mesh import Mesh, sum_by

RADIUS = 2.5  # sigma_s
_PATCH = 0.48  # sigma_s
_COARSEST, _COARSER = 4.0, 1.3  # in sigma_r, and the factor of each step
_ROUNDING = 1e-9  # of the longest side
# parts of the pair sums, and faces at once, that threads share
_PARTS, _FACES_AT_ONCE = 64, 1 << 15


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
    own, reached = _counts(nodes, around)
    start = np.concatenate([[0], np.cumsum(own)])
    out = np.empty((len(nodes.large), 28), np.float32)
    indptr, near = around.rows

    def part(patches: tuple[int, int]) -> None:
        kernels.pair_sums(nodes.places, nodes.weighted_normals, start, indptr, near, *patches, RADIUS * RADIUS, out)

    # the twin in NumPy works on large batches of its own
    map_parallel(_parts(own * reached, _PARTS if kernels.IS_COMPILED else 1), part)
    return out


def _parts(pairs: Labels, count: int) -> list[tuple[int, int]]:
    """Return runs of large patches with about as many pairs each; their number depends on the pairs alone."""
    done = np.cumsum(pairs)
    ends = np.searchsorted(done, np.arange(1, count) * (done[-1] / count))
    bounds = np.unique(np.concatenate([[0], ends, [len(pairs)]]))
    return [(int(first), int(last)) for first, last in itertools.pairwise(bounds)]


def _counts(nodes: _Nodes, around: Reach) -> tuple[Labels, Labels]:
    """Return (P,) int64 each: the number of nodes in each large patch, and of nodes that it reaches."""
    own = np.bincount(nodes.large, minlength=around.near.shape[0])
    return own, np.asarray(around.near @ own, np.int64)


def _at_faces(nodes: _Nodes, sums: Float32, where: Float64, lead: Float64) -> Float64:
    """Return the (M, 4) sums at faces from those at nodes."""
    out = np.empty((len(where), 4))

    def part(band: slice) -> None:
        kernels.at_faces(sums, nodes.places, nodes.of_face[band], where[band], lead[band], out[band])

    for_each_band(len(where), _FACES_AT_ONCE, part)
    return out

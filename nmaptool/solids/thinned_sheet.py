"""The surfaces of a solid with fewer triangles: large ones inside, and all pixels beside moved nodes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import places, touching_vertices
from nmaptool.solids.flat_back import FlatBack, rectangle_corners
from nmaptool.solids.outline import OutlineEdges, merged_edges
from nmaptool.solids.shape import pixels_touching
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.simplify import Steps, Thinner, tolerance_for
from nmaptool.solids.thinned_mesh import Thinned
from nmaptool.types.solid import Nodes, Part

_BAND_PIXELS = 1 << 17
Back = Sheet | FlatBack | None
# front, outline and back of a piece; an open surface has no back
Surfaces = tuple[Sheet, OutlineEdges, Back]


@dataclass(frozen=True, eq=False)
class ThinnedSheet(Sheet):
    """A height field whose pixels away from moved nodes are covered by few triangles.

    ``z_mm`` has the heights of the triangles at all vertices.

    Attributes
    ----------
    full : Sheet
        With two triangles for each pixel.
    mesh : Thinned
    beside : (H, W) bool
        Pixels that keep their two triangles.
    """

    full: Sheet = field(kw_only=True)
    mesh: Thinned = field(kw_only=True)
    beside: Mask = field(kw_only=True)

    @classmethod
    def of(cls, full: Sheet, mesh: Thinned, beside: Mask) -> ThinnedSheet:
        """Put the triangles of a mesh into a sheet."""
        z_mm = np.where(touching_vertices(mesh.mask), mesh.heights_of(full.z_mm), full.z_mm)
        return cls(z_mm, full.shape, full.placing, full.facing, full.first_node, full=full, mesh=mesh, beside=beside)

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return 2 * int(np.count_nonzero(self.beside)) + self.mesh.face_count

    @cached_property
    def z_of_moved(self) -> Float64:
        """Heights of the moved nodes."""
        return self.full.z_of_moved

    def falls(self, top: int, end: int) -> Mask:
        """(end - top, W) bool: whether each pixel is split along its falling diagonal."""
        return np.where(self.beside[top:end], self.full.falls(top, end), self.mesh.falls(top, end))

    def falls_at(self, rows: Nodes, cols: Nodes) -> Mask:
        """(n,) bool: the same for some of the pixels that keep their two triangles."""
        return self.full.falls_at(rows, cols)

    def parts(self) -> Iterator[Part]:
        """The triangles: of pixels beside moved nodes, then of the mesh in rows of tiles."""
        row, col = places(self.beside)
        for first in range(0, len(row), _BAND_PIXELS):
            yield self.pixel_part(row[first : first + _BAND_PIXELS], col[first : first + _BAND_PIXELS])
        width = self.shape.mask.shape[1] + 1
        for top, triangles in self.mesh.bands():
            if len(triangles):
                yield self._mesh_part(triangles, top * width)

    def _mesh_part(self, triangles: Nodes, first: int) -> Part:
        """Triangles of vertices from ``first`` on."""
        local = triangles - first
        used = np.zeros(int(local.max()) + 1, bool)
        used[local] = True
        nodes = np.flatnonzero(used)
        numbers = np.zeros(len(used), np.int32)
        numbers[nodes] = np.arange(len(nodes), dtype=np.int32)
        faces = numbers[local]
        nodes += first
        return Part(self.xyz_of(nodes), faces if self.facing > 0 else faces[:, ::-1], nodes + self.first_node)


class Thinning:
    """Fewer triangles for the front of a piece, its outline and its back.

    A curved back has the triangles of the front, so a shell stays as thick as at its vertices.

    Parameters
    ----------
    front : Sheet
    edges : OutlineEdges
        Of single pixels.
    back : Sheet or FlatBack, optional
        Default: none, for an open surface.
    kept : (H+1, W+1) bool, optional
        Vertices that stay in any case.
    """

    def __init__(self, front: Sheet, edges: OutlineEdges, back: Back = None, *, kept: Mask | None = None) -> None:
        self._front, self._edges, self._back = front, edges, back
        shape = front.shape
        self._beside = pixels_touching(shape.moved, shape)
        mask = shape.mask & ~self._beside
        sheets = [front, back] if isinstance(back, Sheet) else [front]
        heights = [sheet.z_mm for sheet in sheets]
        known = touching_vertices(mask)
        chosen = touching_vertices(self._beside) if kept is None else touching_vertices(self._beside) | kept
        kept = chosen & known
        if isinstance(back, FlatBack):
            kept |= rectangle_corners(back)
        for z_mm in heights:
            _keep_extremes(z_mm, known, kept)
        self._thinner = Thinner(heights, mask, kept)

    def steps(self) -> list[Steps]:
        """Tolerances at which vertices come in, and how many triangles each brings."""
        inside, outline = self._thinner.steps()
        sheets = 2 if isinstance(self._back, Sheet) else 1
        # a vertex on the outline splits a triangle of each sheet, a wall and one of a flat back
        walls = 0 if self._back is None else 2
        return [(inside, 2 * sheets), (outline, sheets + walls + isinstance(self._back, FlatBack))]

    def fewest(self) -> int:
        """Triangles at any error."""
        front, edges, back = self.with_mesh(self._thinner.at(np.inf))
        return front.face_count + (0 if back is None else 2 * len(edges.start) + back.face_count)

    def at(self, bound_mm: float) -> Thinned:
        """The triangles for a value of `steps`."""
        return self._thinner.at(bound_mm)

    def within(self, max_error_mm: float) -> Thinned:
        """The triangles for an error."""
        return self._thinner.within(max_error_mm)

    def with_mesh(self, mesh: Thinned) -> Surfaces:
        """Front, outline and back with the triangles of a mesh."""
        back, shape = self._back, self._front.shape
        active = mesh.active[: shape.mask.shape[0] + 1, : shape.mask.shape[1] + 1] | touching_vertices(self._beside)
        edges = merged_edges(self._edges, active)
        if isinstance(back, FlatBack):
            back = dataclasses.replace(back, outline=edges)
        elif back is not None:
            back = ThinnedSheet.of(back, mesh, self._beside)
        return ThinnedSheet.of(self._front, mesh, self._beside), edges, back


class Thinnable(Protocol):
    """A part of a solid that can have fewer triangles, such as `Thinning`; a mesh has its error in ``max_error_mm``."""

    def steps(self) -> list[Steps]:
        """Tolerances at which vertices come in, and how many triangles each brings."""

    def fewest(self) -> int:
        """Triangles at any error."""

    def at(self, bound_mm: float) -> Any:
        """The mesh for a value of `steps`."""

    def within(self, max_error_mm: float) -> Any:
        """The mesh for an error."""

    def with_mesh(self, mesh: Any) -> Any:
        """What the mesh makes of the part."""


def thin_pieces(
    pieces: Sequence[Thinnable], max_error_mm: float | None, triangles: int | None, given: str | None
) -> tuple[list[Any], float]:
    """Thin the pieces of a solid.

    Parameters
    ----------
    pieces : sequence of Thinning or others of that kind
    max_error_mm : float, optional
    triangles : int, optional
        At most so many in all pieces together, if no error is given.
    given : str, optional
        ``triangles`` as it was given.

    Returns
    -------
    pieces : list
        Of each the value of its ``with_mesh``; of `Thinning` front, outline and back.
    max_error_mm : float
        What was reached.

    Raises
    ------
    InputError
        If the outlines need more triangles.
    """
    if max_error_mm is not None:
        meshes = [piece.within(max_error_mm) for piece in pieces]
    else:
        assert triangles is not None
        steps = [each for piece in pieces for each in piece.steps()]
        bound = tolerance_for(triangles, sum(piece.fewest() for piece in pieces), steps, given)
        del steps
        meshes = [piece.at(bound) for piece in pieces]
    thinned = [piece.with_mesh(mesh) for piece, mesh in zip(pieces, meshes, strict=True)]
    return thinned, max(mesh.max_error_mm for mesh in meshes)


def _keep_extremes(z_mm: Float64, known: Mask, kept: Mask) -> None:
    """Keep a lowest and a highest vertex, of equal ones one that large triangles have."""
    if not known.any():
        return
    for extreme in (z_mm[known].min(), z_mm[known].max()):
        step = 1 << 8
        while step:
            row, col = np.nonzero(known[::step, ::step] & (z_mm[::step, ::step] == extreme))
            if len(row):
                kept[row[0] * step, col[0] * step] = True
                break
            step //= 2

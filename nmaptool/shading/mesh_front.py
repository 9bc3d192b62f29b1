"""The front of a mesh as a height field, seen from straight above."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.render.numpy_raster import visible_faces
from nmaptool.types.height import Height
from nmaptool.types.mesh import Faces, Mesh
from nmaptool.types.picture import Frame

_LONGER_SIDE = 1000
# samples are moved by this share of a pixel, so that they do not fall on the edges of a regular mesh
_NUDGE = 1e-4
# a mesh with this share of its vertices on a lattice, to this share of its spacing, is a relief
_MOSTLY, _ON_LATTICE = 0.8, 0.01
_SMALLEST_PX, _LARGEST_PX = 12, 6000
# values that differ by less than this share of their range are the same
_SAME = 2e-5
# values that at least this share of the points of the most frequent one have are those of the lattice
_COMMON = 0.2


def mesh_front(mesh: Mesh, longer_px: int = _LONGER_SIDE) -> tuple[Height, float]:
    """Return the upper side of a mesh, looking along -z.

    Parameters
    ----------
    mesh : Mesh
        Cleaned, in its own units.
    longer_px : int
        Pixels on the longer side, unless the vertices lie on a lattice: its spacing is then the size of a pixel.

    Returns
    -------
    height : Height
        Above the lowest point of the mesh; its domain is where the mesh is seen.
    thick_mm : float
        The thickness of the mesh below the lowest point that is seen.

    Raises
    ------
    InputError
        If the mesh has no extent across.
    """
    points = mesh.vertices_mm
    low, high = points.min(axis=0), points.max(axis=0)
    longer = float((high - low)[:2].max())
    if longer <= 0:
        raise InputError(f"{mesh.name}: is a line along z; a preview from above would be empty")
    lattice = lattice_of(points)
    pitch = longer / longer_px if lattice is None else lattice.spacing
    left, bottom = (float(v) for v in low[:2])
    if lattice is not None:
        left, bottom = lattice.first_before(left, bottom)
    cols, rows = (
        max(1, math.ceil((float(last) - first) / pitch - 1e-3))
        for first, last in zip((left, bottom), high[:2], strict=True)
    )
    # heights are sampled at the corners of the pixels
    places = np.column_stack([(points[:, 0] - left) / pitch, rows - (points[:, 1] - bottom) / pitch])
    z_mm = np.full((rows + 1, cols + 1), -np.inf)
    if lattice is not None:
        _set_nodes(z_mm, places, points[:, 2] - low[2])
    nudge = _NUDGE if lattice is None else 0.0
    placed = np.column_stack([places[:, 0] + 0.5 + nudge, places[:, 1] + 0.5 - nudge, points[:, 2] - low[2]])
    faces = _upper_faces(mesh)
    seen = visible_faces(placed, faces, rows + 1, cols + 1)
    at = np.nonzero(seen >= 0)
    row, col = (np.asarray(place, np.float64) + 0.5 for place in at)
    z_mm[at] = np.maximum(z_mm[at], _heights(placed, faces[seen[at]], col, row))
    known = np.isfinite(z_mm)
    domain = known[:-1, :-1] & known[1:, :-1] & known[:-1, 1:] & known[1:, 1:]
    if not domain.any():
        raise InputError(f"{mesh.name}: is so thin that no pixel of a preview from above lies inside it")
    height = Height(np.where(touching_vertices(domain), z_mm, 0), domain, Frame(rows, cols, pitch))
    return height, max(height.range_mm[0], 1e-3 * longer)


def _upper_faces(mesh: Mesh) -> Faces:
    """The faces that may be seen from above: backs have long, thin triangles, which take long to draw."""
    geometry = mesh.geometry
    up = geometry.normals[:, 2] * geometry.areas
    middle = mesh.vertices[:, 2][mesh.faces].mean(axis=1) - mesh.vertices[:, 2].min()
    # the volume, if the mesh is closed; negative if it is inside out
    return mesh.faces[up > 0] if float(up @ middle) > 0 else mesh.faces


@dataclass(frozen=True)
class Lattice:
    """A square grid of points, seen from above."""

    spacing: float
    x: float
    y: float

    def first_before(self, x: float, y: float) -> tuple[float, float]:
        """The column and the row of the lattice at or before a place."""
        across, up = (math.floor((v - o) / self.spacing + _ON_LATTICE) for v, o in ((x, self.x), (y, self.y)))
        return self.x + across * self.spacing, self.y + up * self.spacing


def lattice_of(points: Float64) -> Lattice | None:
    """The square grid on which most points lie, seen from above; None if there is none.

    Reliefs have their vertices on one, so their heights are found again without loss.
    """
    (across, x), (up, y) = (_spacing(points[:, axis]) for axis in (0, 1))
    spacing = min(across, up)
    if not spacing > 0:
        return None
    if not _SMALLEST_PX <= float(np.ptp(points[:, :2], axis=0).max()) / spacing <= _LARGEST_PX:
        return None
    steps = (points[:, :2] - (x, y)) / spacing
    off = np.abs(steps - np.round(steps)).max(axis=1)
    return Lattice(spacing, x, y) if np.mean(off < _ON_LATTICE) > _MOSTLY else None


def _spacing(values: Float64) -> tuple[float, float]:
    """The usual distance between the values that many points have, 0 if they are all the same, and one of them."""
    ordered = np.sort(values)
    # rounding in the file separates values that are the same
    starts = np.flatnonzero(np.diff(ordered, prepend=-np.inf) > _SAME * (ordered[-1] - ordered[0]))
    counts = np.diff(starts, append=len(ordered))
    common = ordered[starts][counts >= _COMMON * counts.max()]
    if len(common) < 2:
        return 0.0, float(common[0])
    usual = float(np.median(np.diff(common)))
    # the whole width fixes it more precisely
    return float((common[-1] - common[0]) / round((common[-1] - common[0]) / usual)), float(common[0])


def _set_nodes(z_mm: Float64, places: Float64, heights: Float64) -> None:
    """Set the heights of the vertices that lie on the lattice: the highest of each."""
    nearest = np.round(places)
    on = np.abs(places - nearest).max(axis=1) < _ON_LATTICE
    col, row = nearest[on].astype(np.intp).T
    np.maximum.at(z_mm, (row, col), heights[on])


def _heights(points: Float64, faces: Faces, x: Float64, y: Float64) -> Float64:
    """Heights of points of faces, at places across."""
    a, b, c = (points.take(faces[:, k], axis=0) for k in range(3))
    wb = (x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])
    wc = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    low, high = (pick(pick(a[:, 2], b[:, 2]), c[:, 2]) for pick in (np.minimum, np.maximum))
    z = a[:, 2] + (wb * (b[:, 2] - a[:, 2]) + wc * (c[:, 2] - a[:, 2])) / np.where(area == 0, 1, area)
    return np.asarray(z.clip(low, high))

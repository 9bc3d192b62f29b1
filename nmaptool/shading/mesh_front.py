"""The front of a mesh as a height field, seen from straight above."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.errors import InputError
from nmaptool.render.numpy_raster import visible_faces
from nmaptool.types.height import Height
from nmaptool.types.mesh import Mesh
from nmaptool.types.picture import Frame

_LONGER_SIDE = 1000
# samples are moved by this share of a pixel, so that they do not fall on the edges of a regular mesh
_NUDGE = 1e-4


def mesh_front(mesh: Mesh, longer_px: int = _LONGER_SIDE) -> tuple[Height, float]:
    """Return the upper side of a mesh, looking along -z.

    Parameters
    ----------
    mesh : Mesh
        Cleaned, in its own units.
    longer_px : int
        Pixels on the longer side.

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
    pitch = longer / longer_px
    cols, rows = (max(1, math.ceil(float(side) / pitch - 1e-6)) for side in (high - low)[:2])
    # heights are sampled at the corners of the pixels
    placed = np.column_stack(
        [
            (points[:, 0] - low[0]) / pitch + 0.5 + _NUDGE,
            rows - (points[:, 1] - low[1]) / pitch + 0.5 - _NUDGE,
            points[:, 2] - low[2],
        ]
    )
    seen = visible_faces(placed, mesh.faces, rows + 1, cols + 1)
    at = np.nonzero(seen >= 0)
    if not len(at[0]):
        raise InputError(f"{mesh.name}: is so thin that no pixel of a preview from above sees it")
    z_mm = np.zeros(seen.shape)
    z_mm[at] = _heights(placed, mesh.faces[seen[at]], at[1] + 0.5, at[0] + 0.5)
    corners = seen >= 0
    domain = corners[:-1, :-1] & corners[1:, :-1] & corners[:-1, 1:] & corners[1:, 1:]
    if not domain.any():
        raise InputError(f"{mesh.name}: is so thin that no pixel of a preview from above lies inside it")
    height = Height(z_mm, domain, Frame(rows, cols, pitch))
    return height, max(height.range_mm[0], 1e-3 * longer)


def _heights(points: np.ndarray, faces: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Heights of points of faces, at places across."""
    a, b, c = (points.take(faces[:, k], axis=0) for k in range(3))
    wb = (x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])
    wc = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    low, high = (pick(pick(a[:, 2], b[:, 2]), c[:, 2]) for pick in (np.minimum, np.maximum))
    z = a[:, 2] + (wb * (b[:, 2] - a[:, 2]) + wc * (c[:, 2] - a[:, 2])) / np.where(area == 0, 1, area)
    return np.asarray(z.clip(low, high))

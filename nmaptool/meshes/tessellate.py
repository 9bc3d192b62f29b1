"""Triangulate height fields in mm: +x right, +y up, +z towards the viewer, the picture's lower left corner at 0."""

from __future__ import annotations

import numpy as np

from nmaptool.types.height import Height
from nmaptool.types.inputs import as_height
from nmaptool.types.mesh import Mesh
from nmaptool.types.relief import Relief


def surface_mesh(height: Height | Relief) -> Mesh:
    """Triangulate a height field: two triangles for each pixel of its domain.

    Each pixel is split along the diagonal along which the surface bends less, which preserves diagonal ridges and
    valleys.

    Parameters
    ----------
    height : Height or Relief

    Returns
    -------
    Mesh
        In mm: +x right, +y up, +z towards the viewer, the lower left corner of the picture at (0, 0).

    Raises
    ------
    UsageError
        If the value is neither, such as an array, which has no pixel size.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.surface_mesh(height)
    <Mesh mesh: 12 vertices, 12 faces, 1 mm per unit (assumed)>
    """
    height = as_height(height)
    rows = height.frame.rows
    used = height.vertex_mask
    index = np.full(used.shape, -1, np.int32)
    index[used] = np.arange(int(used.sum()), dtype=np.int32)
    row, col = np.nonzero(used)
    pitch = height.pitch_mm
    vertices = np.column_stack([col * pitch, (rows - row) * pitch, height.z_mm[used]])
    inside = height.domain
    z = np.pad(height.z_mm, 1, mode="edge")
    bend_falling = np.abs(z[:-3, :-3] - z[1:-2, 1:-2] - z[2:-1, 2:-1] + z[3:, 3:])
    bend_rising = np.abs(z[3:, :-3] - z[2:-1, 1:-2] - z[1:-2, 2:-1] + z[:-3, 3:])
    falls = bend_falling <= bend_rising
    nw, ne = index[:-1, :-1], index[:-1, 1:]
    sw, se = index[1:, :-1], index[1:, 1:]
    down, up = inside & falls, inside & ~falls
    parts = [
        (nw[down], sw[down], se[down]),
        (nw[down], se[down], ne[down]),
        (nw[up], sw[up], ne[up]),
        (sw[up], se[up], ne[up]),
    ]
    faces = np.concatenate([np.column_stack(part) for part in parts])
    return Mesh(vertices, faces)

"""A height field as a mesh in memory."""

from __future__ import annotations

from nmaptool.options import SolidOptions
from nmaptool.solids.solid import solid
from nmaptool.types.height import Height
from nmaptool.types.mesh import Mesh
from nmaptool.types.relief import Relief


def surface_mesh(height: Height | Relief) -> Mesh:
    """Triangulate a height field: two triangles for each pixel of its domain.

    Each pixel is split along the diagonal along which the surface bends less, which preserves diagonal ridges and
    valleys. For closed solids, smooth outlines and fewer triangles see `nmaptool.solid`.

    Parameters
    ----------
    height : Height or Relief

    Returns
    -------
    Mesh
        In mm: +x right, +y up, +z to the viewer, the lower left corner of the picture at (0, 0).

    Raises
    ------
    UsageError
        If it is something else, such as an array, which does not know the size of a pixel.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.surface_mesh(height)
    <Mesh mesh: 12 vertices, 12 faces, 1 mm per unit (assumed)>
    """
    return solid(height, SolidOptions(outline="exact")).to_mesh()

"""Heights along a moved outline, continued from the surface inside: pixels on the outline are motif only in part."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.shape import Shape

_REACH = 3
_NEAR_PX = 1.2
_FEWEST = 4
# keeps the fit of a plane to vertices on one line solvable
_RIDGE = 1e-3


def rim_heights(z_mm: Float64, shape: Shape) -> Float64:
    """Heights of the moved nodes of a shape.

    Each lies on the plane through the nearby vertices inside, weighted by their distance. Where there are too few of
    them, such as on lines of single pixels, a node keeps the height of its vertex.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
    shape : Shape

    Returns
    -------
    (n,) float64
        In the order of ``shape.moved``.
    """
    vertex = shape.vertex_of(shape.moved)
    own: Float64 = z_mm.ravel()[vertex]
    if shape.keeps_heights or not len(vertex):
        return own
    rows, cols = z_mm.shape
    inside = (
        touching_vertices(shape.mask) & ~touching_vertices(np.pad(~shape.mask, 1, constant_values=True))[1:-1, 1:-1]
    )
    row, col = np.divmod(vertex, cols)
    target = shape.places_px(shape.moved)
    step = np.arange(-_REACH, _REACH + 1)
    down, right = (each.ravel() for each in np.meshgrid(step, step, indexing="ij"))
    r, c = row[:, None] + down, col[:, None] + right
    valid = (r >= 0) & (r < rows) & (c >= 0) & (c < cols)
    r, c = np.clip(r, 0, rows - 1), np.clip(c, 0, cols - 1)
    x, y = c - target[:, :1], r - target[:, 1:]
    weight = np.exp(-(x**2 + y**2) / (2 * _NEAR_PX**2)) * (valid & inside[r, c])
    count = (weight > 0).sum(axis=1)
    basis = np.stack([np.ones_like(x), x, y], axis=-1)
    weighted = basis * weight[..., None]
    normal = np.einsum("nkb,nkc->nbc", weighted, basis)
    normal += _RIDGE * np.einsum("nbb->n", normal)[:, None, None] * np.diag([0.0, 1.0, 1.0]) + 1e-12 * np.eye(3)
    load = np.einsum("nkb,nk->nb", weighted, z_mm[r, c] - own[:, None])
    fitted: Float64 = own + np.linalg.solve(normal, load[..., None])[:, 0, 0]
    is_split = np.isin(vertex, shape.splits.vertices)
    return np.where((count >= _FEWEST) & ~is_split, fitted, own)

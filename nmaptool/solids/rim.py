"""Heights along a moved outline, continued from the surface inside: pixels on the outline are motif only in part."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.shape import Shape
from nmaptool.types.solid import Nodes

_REACH = 3
_NEAR_PX = 1.2
_FEWEST = 4
_BAND_NODES = 1 << 13
# keeps the fit of a plane to vertices on one line solvable
_RIDGE = 1e-3


def rim_heights(z_mm: Float64, shape: Shape) -> Float64:
    """Heights of the moved nodes of a shape.

    Each lies on the plane through the nearby vertices inside, weighted by their distance, and at most half their range
    beyond them. Where there are too few of them, such as on lines of single pixels, a node keeps the height of its
    vertex.

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
    padded = np.pad(~shape.mask, 1, constant_values=True)
    inside = touching_vertices(shape.mask) & ~touching_vertices(padded)[1:-1, 1:-1]
    target = shape.places_px(shape.moved)
    parts = [slice(first, first + _BAND_NODES) for first in range(0, len(vertex), _BAND_NODES)]
    fitted = np.concatenate([_fitted(z_mm, inside, vertex[part], target[part]) for part in parts])
    return np.where(np.isin(vertex, shape.splits.vertices), own, fitted)


def _fitted(z_mm: Float64, inside: Mask, vertex: Nodes, target: Float64) -> Float64:
    """(n,) heights at places near some vertices, by planes through the vertices inside around them."""
    rows, cols = z_mm.shape
    own: Float64 = z_mm.ravel()[vertex]
    row, col = np.divmod(vertex, cols)
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
    fitted = _near_neighbours(fitted, np.where(weight > 0, z_mm[r, c], np.nan), count > 0)
    return np.where(count >= _FEWEST, fitted, own)


def _near_neighbours(fitted: Float64, around: Float64, known: Mask) -> Float64:
    """Heights brought back to the range of the heights around them (NaN where unknown), widened by half."""
    out = fitted.copy()
    low, high = np.nanmin(around[known], axis=1), np.nanmax(around[known], axis=1)
    margin = (high - low) / 2
    out[known] = np.clip(out[known], low - margin, high + margin)
    return out

"""Corners of an outline rounded to a radius, inner and outer ones."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import places

# around the reach, for the crossings of the outline
MARGIN_PX = 3


def rounded(coverage: Float32, radius_px: float) -> Float32:
    """Coverage with the corners of its outline rounded to a radius.

    The outline is opened and then closed with a disc: parts and gaps narrower than twice the radius disappear, straight
    edges stay where they are. The border of the picture counts as outline.

    Parameters
    ----------
    coverage : (H, W) float32
        Share of each pixel that is covered, 0 to 1.
    radius_px : float

    Returns
    -------
    (H, W) float32
    """
    pad = math.ceil(2 * radius_px) + MARGIN_PX
    reach_px = 2 * radius_px + MARGIN_PX
    level = np.pad(coverage.astype(np.float64), pad) - 0.5
    # a disc fits into what opening leaves, and then into what surrounds it
    for by_px in (-radius_px, radius_px, radius_px, -radius_px):
        level = _distance(level, reach_px) + by_px
    return np.clip(level + 0.5, 0.0, 1.0)[pad:-pad, pad:-pad].astype(np.float32)


def _distance(level: Float64, reach_px: float) -> Float64:
    """Signed distance of pixel centres from where a field is 0, positive inside, up to a reach."""
    from scipy import ndimage, spatial  # take long to load

    inside = level >= 0
    points = _crossings(level, inside)
    signed = np.where(inside, reach_px, -reach_px)
    if not len(points):
        return signed
    border = ndimage.binary_dilation(inside) & ~ndimage.binary_erosion(inside, border_value=1)
    row, col = places(ndimage.distance_transform_edt(~border) <= reach_px)
    found, _ = spatial.cKDTree(points).query(np.column_stack([row, col]), distance_upper_bound=reach_px)
    signed[row, col] = np.where(inside[row, col], 1, -1) * np.minimum(found, reach_px)
    return signed


def _crossings(level: Float64, inside: Mask) -> Float64:
    """(n, 2) rows and columns at which a field passes 0 between neighbouring pixel centres, diagonal ones included."""
    found = []
    rows, cols = level.shape
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        first = (slice(0, rows - down), slice(max(0, -right), cols - max(0, right)))
        second = (slice(down, rows), slice(max(0, right), cols - max(0, -right)))
        row, col = places(inside[first] != inside[second])
        a, b = level[first][row, col], level[second][row, col]
        share = a / (a - b)
        found.append(np.column_stack([row + share * down, col + max(0, -right) + share * right]))
    return np.concatenate(found)

"""Heights along an exact outline."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.types.height import Height


def heights_at(z_mm: Float64, xy_mm: Float64, pitch_mm: float) -> Float64:
    """(n,) heights between the vertices of a grid, bilinear in each pixel.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
    xy_mm : (n, 2) float64
        From the lower left corner of the grid, y up; places outside count as the nearest on its border.
    pitch_mm : float
    """
    rows, cols = z_mm.shape[0] - 1, z_mm.shape[1] - 1
    x = np.clip(xy_mm[:, 0] / pitch_mm, 0, cols)
    y = np.clip(rows - xy_mm[:, 1] / pitch_mm, 0, rows)
    col = np.minimum(x.astype(np.int64), cols - 1)
    row = np.minimum(y.astype(np.int64), rows - 1)
    x, y = x - col, y - row
    # in this form, equal heights stay exactly equal
    upper = z_mm[row, col] + x * (z_mm[row, col + 1] - z_mm[row, col])
    lower = z_mm[row + 1, col] + x * (z_mm[row + 1, col + 1] - z_mm[row + 1, col])
    found: Float64 = upper + y * (lower - upper)
    return found


def heights_along(points: OutlinePoints, z_mm: Float64, height: Height) -> Float64:
    """(n,) heights of the points of an outline, within the range of the heights of the domain."""
    low, high = height.range_mm
    found: Float64 = np.clip(heights_at(z_mm, points.xy_mm, height.pitch_mm), low, high)
    return found


def heights_inward(points: OutlinePoints, z_mm: Float64, pitch_mm: float, count: int) -> Float64:
    """(n, count) heights at the points, one pixel further inside, and so on."""
    corners = points.xy_mm[points.is_corner]
    way = (corners[points.corner_after] - corners)[points.segment]
    inward = np.column_stack([-way[:, 1], way[:, 0]]) / np.hypot(*way.T)[:, None]
    steps = [points.xy_mm + number * pitch_mm * inward for number in range(count)]
    return np.stack([heights_at(z_mm, each, pitch_mm) for each in steps], axis=1)

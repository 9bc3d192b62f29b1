"""Walls of a plate: below each edge of its outline one plane polygon, from the points of the front to the back."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.types.solid import Nodes


def walls_to_corners(points: OutlinePoints, top_mm: Float64, bottom_mm: float, pitch_mm: float) -> Nodes:
    """Triangulate walls that pass through all points above, and through the corners of the outline below.

    Parameters
    ----------
    points : OutlinePoints
    top_mm : (n,) float64
        Heights of the points.
    bottom_mm : float
        Height of the corners below, which lie lower than all points.
    pitch_mm : float

    Returns
    -------
    (n + c, 3) int64
        Numbers of points, then of corners, facing away from the plate.
    """
    count = len(top_mm)
    first = np.flatnonzero(points.is_corner)
    below, below_after = count + np.arange(len(first)), count + points.corner_after
    is_single = np.diff(first, append=count) == 1
    one, after = first[is_single], points.after[first[is_single]]
    plain = [
        np.stack([after, one, below[is_single]], axis=1),
        np.stack([after, below[is_single], below_after[is_single]], axis=1),
    ]
    return np.concatenate([*plain, _polygons(points, top_mm, bottom_mm, pitch_mm, ~is_single)])


def _polygons(points: OutlinePoints, top_mm: Float64, bottom_mm: float, pitch_mm: float, chosen: Mask) -> Nodes:
    """Triangles of the walls below some edges, which are laid side by side in one plane."""
    if not chosen.any():
        return np.zeros((0, 3), np.int64)
    count, rings, numbers, left = len(top_mm), [], [], 0.0
    first = np.flatnonzero(points.is_corner)
    ends = np.append(first[1:], count)
    for segment in np.flatnonzero(chosen):
        above = np.append(np.arange(first[segment], ends[segment]), points.after[ends[segment] - 1])
        along = left + np.hypot(*(points.xy_mm[above] - points.xy_mm[above[0]]).T)
        across = np.concatenate([along[[0, -1]], along[::-1]])
        rings.append(np.column_stack([across, np.concatenate([[bottom_mm, bottom_mm], top_mm[above[::-1]]])]))
        numbers.append(np.concatenate([[count + segment, count + points.corner_after[segment]], above[::-1]]))
        left = along[-1] + pitch_mm
    found: Nodes = np.concatenate(numbers)[triangulated([ring / pitch_mm for ring in rings], unit_mm=pitch_mm)]
    return found

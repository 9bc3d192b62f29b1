"""Backs that are not flat: a shell that follows the front, and a solid that is hollowed from behind."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import touching_vertices


def shell_back(z_mm: Float64, mask: Mask, thickness_mm: float, pitch_mm: float) -> Float64:
    """(H+1, W+1) float64 heights of a back that leaves at least this thickness behind a front, square to its surface.

    The front is eroded by a paraboloid, which encloses the sphere of that radius and can be applied row by row and
    column by column. On a slope s the shell is (1 + s^2 / 2) / sqrt(1 + s^2) times as thick as asked for.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights of the front.
    mask : (H, W) bool
        Pixels of the front.
    thickness_mm, pitch_mm : float
    """
    z = np.where(touching_vertices(mask), z_mm, np.inf)
    reach = math.ceil(thickness_mm / pitch_mm)
    for axis in (0, 1):
        z = _eroded(z, axis, reach, pitch_mm**2 / (2 * thickness_mm))
    z -= thickness_mm
    return np.where(np.isfinite(z), z, 0.0)


def hollow_back(
    z_mm: Float64, mask: Mask, wall_mm: float, base_mm: float, pitch_mm: float, whole: Mask | None = None
) -> Float64:
    """(H+1, W+1) float64 heights of a back with a pocket: walls and front are at least so thick.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights of the front.
    mask : (H, W) bool
        Pixels of the front.
    wall_mm, base_mm : float
        Thickness of what is left; how far the back lies below height 0.
    pitch_mm : float
    whole : (H, W) bool, optional
        Pixels of the front that an exact outline does not cut. Default: all of them.
    """
    from scipy import ndimage  # takes long to load

    padded = np.pad(mask if whole is None else whole, 1)
    # the side of the pocket reaches to the neighbours of its vertices, diagonal ones beside an exact outline
    side_mm = pitch_mm if whole is None else math.sqrt(2) * pitch_mm
    # distance of each vertex from the nearest vertex of the outside, the outline's included
    outside = touching_vertices(~padded)
    to_outline = ndimage.distance_transform_edt(~outside)[1:-1, 1:-1] * pitch_mm
    pocket = shell_back(z_mm, mask, wall_mm, pitch_mm)
    return np.where(to_outline > wall_mm + side_mm, np.maximum(pocket, -base_mm), -base_mm)


def _eroded(z: Float64, axis: int, reach: int, rise: float) -> Float64:
    """The least of a value and its neighbours within a reach, each raised by ``rise`` times its distance squared."""
    z = np.moveaxis(z, axis, 0)
    out = z.copy()
    for step in range(1, min(reach, len(z) - 1) + 1):
        raised = z + rise * step**2
        np.minimum(out[step:], raised[:-step], out=out[step:])
        np.minimum(out[:-step], raised[step:], out=out[:-step])
    return np.moveaxis(out, 0, axis)

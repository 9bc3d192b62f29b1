"""The tolerance of the fitted surface near jumps, where compression and smoothing distort the stored heights."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.grid import places

# error as a share of the jump's height, by distance from it in px: first mixed pixels, then ringing
_SPOILT = (0.6, 0.06, 0.03, 0.015)
# px from a jump within which a surface may turn away
_TURNING = 6
_SQUARE = np.ones((2 * _TURNING + 1, 2 * _TURNING + 1), np.uint8)
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


def slack_of(heights: Float32, jumps: Float32, tolerance: float, unsure: float, least_mixed: float | None) -> Float32:
    """Return (H, W) float32: how far the surface may leave each height, in px.

    Parameters
    ----------
    heights, jumps : (H, W) float32
        Heights, and height of the jump at each pixel, in px.
    tolerance : float
        Away from jumps.
    unsure : float
        Noise of heights near edges.
    least_mixed : float or None
        Smallest difference of a mixed pixel from its side; None if there are no mixed pixels.
    """
    slack = np.full(heights.shape, tolerance, np.float32)
    if unsure:
        widen_tolerance(slack, jumps)
    elif least_mixed is not None and tolerance:
        np.copyto(slack, least_mixed, where=jumps > 0)
    if tolerance and not unsure:
        narrow_tolerance(slack, heights, jumps)
    return slack


def widen_tolerance(tolerance: Float32, jumps: Float32) -> None:
    """Increase the tolerance near each jump to a share of its height, in place.

    Parameters
    ----------
    tolerance, jumps : (H, W) float32
        Tolerance, and height of the jump at each pixel, in px.
    """
    reach = jumps
    for share in _SPOILT:
        np.maximum(tolerance, np.float32(share) * reach, out=tolerance)
        reach = cv2.dilate(reach, _CROSS)


def narrow_tolerance(tolerance: Float32, heights: Float32, jumps: Float32) -> None:
    """Reduce the tolerance where heights near a jump are steep, in place.

    The surface with the least bending deviates from one that turns away. Where it is steep, a step of the stored
    heights changes its normals little, so following the stored heights closely costs little.

    Parameters
    ----------
    tolerance, heights, jumps : (H, W) float32
        Tolerance, heights, and height of the jump at each pixel, in px.
    """
    near = cv2.dilate((jumps > 0).view(np.uint8), _SQUARE)
    row, col = places(near)
    slope = np.hypot(_least_step(heights, row, col, 0), _least_step(heights, row, col, 1))
    tolerance[row, col] /= np.maximum(slope, np.float32(1))


def _least_step(heights: Float32, row: NDArray[np.intp], col: NDArray[np.intp], axis: int) -> Float32:
    """Return each pixel's smaller step along an axis, (K,) float32, never that of a jump; 0 at the picture's edge."""
    place, limit = (row, col)[axis], heights.shape[axis]
    here = heights[row, col]
    steps = []
    for by in (-1, 1):
        other = np.clip(place + by, 0, limit - 1)
        steps.append(np.abs((heights[other, col] if axis == 0 else heights[row, other]) - here))
    return np.asarray(np.minimum(steps[0], steps[1]))

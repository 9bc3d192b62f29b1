"""The flat ground that a motif stands on: large patches at the picture's lowest height."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask

# the smallest patch, in pixels and as a share of the picture, and the least share of all patches together
_PATCH_PIXELS, _PATCH_SHARE, _LEAST_SHARE = 16, 2e-4, 0.02
# with a larger share, the picture is nothing but ground
_MOST_SHARE = 0.9995


def find_ground(heights: Float32, lowest: float, known: Mask, slack: Float32 | None) -> Mask:
    """Return (H, W) bool: large patches at most ``slack`` above the lowest height; all False if their share is small.

    Parameters
    ----------
    heights : (H, W) float32
    lowest : float
        Lowest stored height.
    known : (H, W) bool
        Pixels that have a height.
    slack : (H, W) float32 or None
        Noise, in the unit of the heights.
    """
    low = is_low(heights, lowest, known, slack)
    nowhere = np.zeros_like(low)
    if np.count_nonzero(low) < _LEAST_SHARE * low.size:
        return nowhere
    _, labels, stats, _ = cv2.connectedComponentsWithStats(low.view(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    sizes = stats[:, cv2.CC_STAT_AREA].copy()
    sizes[0] = 0
    keep = kept_patches(sizes, low.size, int(np.count_nonzero(known)))
    return nowhere if keep is None else np.asarray(keep[labels])


def kept_patches(sizes: NDArray[Any], pixels: int, known: int) -> Mask | None:
    """Return which patches at the lowest height are ground; None if there is no ground.

    Parameters
    ----------
    sizes : (N,) int
        Pixels of each patch.
    pixels, known : int
        Pixels of the picture, and those that have a height.
    """
    if sizes.sum() < _LEAST_SHARE * pixels:
        return None
    keep: Mask = sizes >= max(_PATCH_PIXELS, _PATCH_SHARE * pixels)
    share = int(sizes[keep].sum()) / max(known, 1)
    return keep if _LEAST_SHARE <= share <= _MOST_SHARE else None


def is_low(heights: Float32, lowest: float, known: Mask, slack: Float32 | None) -> Mask:
    """Return (H, W) bool: pixels at most ``slack`` above the lowest height; arguments as for `find_ground`."""
    low: Mask = heights <= (np.float32(lowest) if slack is None else slack + np.float32(lowest))
    low &= known
    return low

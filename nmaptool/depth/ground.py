"""The flat ground that a motif stands on: large patches at the picture's lowest height."""

from __future__ import annotations

import cv2
import numpy as np

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
    low = heights <= (np.float32(lowest) if slack is None else slack + np.float32(lowest))
    low &= known
    nowhere = np.zeros_like(low)
    if np.count_nonzero(low) < _LEAST_SHARE * low.size:
        return nowhere
    _, labels, stats, _ = cv2.connectedComponentsWithStats(low.view(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    keep = stats[:, cv2.CC_STAT_AREA] >= max(_PATCH_PIXELS, _PATCH_SHARE * low.size)
    keep[0] = False
    ground: Mask = keep[labels]
    share = int(np.count_nonzero(ground)) / max(int(np.count_nonzero(known)), 1)
    return ground if _LEAST_SHARE <= share <= _MOST_SHARE else nowhere

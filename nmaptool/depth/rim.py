"""How far a fitted surface may leave the stored heights near jumps, where compression and smoothing spoil them."""

from __future__ import annotations

import cv2
import numpy as np

from nmaptool.arrays import Float32

# of the jump's height, by distance from it in px: half mixed, then ringing
_SPOILT = (0.6, 0.06, 0.03, 0.015)
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


def widen_tolerance(tolerance: Float32, jumps: Float32) -> None:
    """Let the surface leave the heights of pixels near a jump by a share of it, in place.

    Parameters
    ----------
    tolerance, jumps : (H, W) float32
        In px.
    """
    reach = jumps
    for share in _SPOILT:
        np.maximum(tolerance, np.float32(share) * reach, out=tolerance)
        reach = cv2.dilate(reach, _CROSS)

"""Soft edges."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float32


def feathered(coverage: Float32, width_px: float) -> Float32:
    """Coverage that rises from 0 at its outline to full over a width inside it.

    Parameters
    ----------
    coverage : (H, W) float32 in [0, 1]
        The picture's own edge is an outline, too.
    width_px : float
        Width of the soft edge, zero or more.

    Returns
    -------
    (H, W) float32
        Coverage times a smooth step of the distance to the outline.
    """
    import cv2

    if width_px <= 0:
        return coverage
    inside = cv2.copyMakeBorder((coverage >= 0.5).astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    # to the nearest centre outside; the outline lies half a pixel before it
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] - np.float32(0.5)
    step = (distance / np.float32(width_px)).clip(0, 1)
    soft: Float32 = coverage * (step * step * (3 - 2 * step))
    return soft

"""Soft edges: feathering, and details with soft edges on bases with soft edges."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32


def feathered(coverage: Float32, width_px: float) -> Float32:
    """Return coverage that rises from 0 at its outline to its full value over a width inside it.

    Parameters
    ----------
    coverage : (H, W) float32 in [0, 1]
        The edge of the picture is an outline, too.
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
    # distance to the nearest pixel centre outside; the outline is half a pixel closer
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    # its last bits depend on the size of the picture, but squares of distances are whole numbers
    distance = np.sqrt(np.rint(np.square(distance, dtype=np.float64))).astype(np.float32) - np.float32(0.5)
    step = (distance / np.float32(width_px)).clip(0, 1)
    soft: Float32 = coverage * (step * step * (3 - 2 * step))
    return soft


def detail_weight(above: Float32, own: Float32, below: Float32) -> Float32:
    """Return the weight of a detail at soft outlines.

    A detail with the same outline as its base acts fully along it; a detail that ends inside the base fades out there.

    Parameters
    ----------
    above : (H, W) float32 in [0, 1]
        Coverage of the detail, masked and feathered.
    own : (H, W) float32 in [0, 1]
        Coverage of the detail without mask and feather, nowhere less than ``above``.
    below : (H, W) float32 in [0, 1]
        Coverage of the base.

    Returns
    -------
    (H, W) float32
        ``above`` divided by the larger of the two others; 0 where ``above`` is 0.
    """
    weight = np.zeros_like(above)
    np.divide(above, np.maximum(own, below), out=weight, where=above > 0)
    return weight.clip(0, 1, out=weight)

"""Soft edges: made, and laid on each other."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32


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


def detail_weight(above: Float32, own: Float32, below: Float32) -> Float32:
    """How much of a detail acts on what lies below where outlines are soft.

    A pixel's share of a surface is the same share for its detail: a detail with the outline of its base acts in full
    along it, and one that ends within the base fades out as it ends.

    Parameters
    ----------
    above : (H, W) float32 in [0, 1]
        What shows of the detail: its own coverage, masked and feathered.
    own : (H, W) float32 in [0, 1]
        Its own coverage, nowhere less than ``above``.
    below : (H, W) float32 in [0, 1]
        Coverage of what it changes.

    Returns
    -------
    (H, W) float32
        ``above`` over the larger of the two others; 0 where nothing shows.
    """
    weight = np.zeros_like(above)
    np.divide(above, np.maximum(own, below), out=weight, where=above > 0)
    return weight.clip(0, 1, out=weight)

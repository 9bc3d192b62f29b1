"""Recesses of a height field, where dirt and patina stay when its edges are worn bright."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.shading.field import Field

# width of a recess, as a share of the picture's longer side
_WIDTH = 0.012
# a slope of a recess's walls that counts as fully recessed
_STEEP = 0.22
_OPEN_SKY, _CLOSED_SKY = 0.96, 0.55


def recess_share(field: Field, sky: Float32, tarnish: float = 0.0) -> Float32:
    """(h, w) float32, 0 to 1: how much each pixel lies in a recess.

    Parameters
    ----------
    field : Field
    sky : (h, w) float32
        Share of the sky that each pixel sees.
    tarnish : float
        What a level place counts; edges count less.
    """
    import cv2

    z_mm = field.centers_mm
    sigma = max(1.0, _WIDTH * max(field.shape))
    small = cv2.resize(z_mm, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) if sigma > 4 else z_mm
    around = cv2.GaussianBlur(small, (0, 0), sigma * small.shape[1] / z_mm.shape[1], borderType=cv2.BORDER_REFLECT_101)
    around = cv2.resize(around, z_mm.shape[::-1], interpolation=cv2.INTER_LINEAR) if sigma > 4 else around
    depth = (around - z_mm) * np.float32(1 / (_STEEP * sigma * field.pitch_mm))
    hidden = (np.float32(_OPEN_SKY) - sky) * np.float32(1 / (_OPEN_SKY - _CLOSED_SKY))
    share = (np.float32(tarnish) + np.clip(hidden, 0, 1) + np.clip(depth, -1, 1)).clip(0, 1)
    return np.asarray(share * share * (3 - 2 * share), np.float32)

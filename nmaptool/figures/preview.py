"""A picture of a relief under two raking lights, as a carving would look."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.grid import height_slopes
from nmaptool.types.height import Height
from nmaptool.types.inputs import as_height
from nmaptool.types.picture import Frame
from nmaptool.types.relief import Relief

# azimuth (counter-clockwise from +x) and elevation in degrees, and strength: a low key light from the upper left, a
# weak fill from the right, a little ambient light
_LIGHTS = ((135.0, 38.0, 0.74), (15.0, 22.0, 0.22))
_AMBIENT = 0.09
_BACKDROP = 0.16
_TONE = 0.85  # lifts the shadows a little
_SMALLEST_LONGER_SIDE = 900
_WARM = np.array([1.0, 0.975, 0.94])
Picture = NDArray[np.uint8]


def _direction(azimuth: float, elevation: float) -> Float64:
    a, e = np.radians(azimuth), np.radians(elevation)
    return np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])


def lambert(height: Height) -> Float64:
    """Return the (H, W) brightness in [0, 1] of each pixel under the two lights; the backdrop outside the domain."""
    p, q = height_slopes(height.z_mm / height.pitch_mm)
    length = np.sqrt(1 + p * p + q * q)
    light = np.full(p.shape, _AMBIENT)
    for azimuth, elevation, strength in _LIGHTS:
        x, y, up = _direction(azimuth, elevation)
        light += strength * np.clip((-p * x - q * y + up) / length, 0, None)
    light[~height.domain] = _BACKDROP
    return light.clip(0, 1)


def preview(height: Height | Relief) -> Picture:
    """Shade a relief under two raking lights; small ones are enlarged by an integer factor.

    Parameters
    ----------
    height : Height or Relief

    Returns
    -------
    (h, w, 3) uint8
        sRGB, for display; the longer side has 900 px or more.

    Raises
    ------
    UsageError
        If the value is neither a Height nor a Relief.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.preview(height).shape
    (600, 900, 3)
    """
    import cv2

    height = as_height(height)
    light = lambert(height).astype(np.float32)
    factor = enlargement(height.frame)
    if factor > 1:
        light = cv2.resize(light, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
    return in_colors(light)


def enlargement(frame: Frame) -> int:
    """Return the factor by which `preview` enlarges a picture."""
    return max(1, -(-_SMALLEST_LONGER_SIDE // frame.longer_side))


def in_colors(light: NDArray[Any]) -> Picture:
    """Return (h, w) brightness as (h, w, 3) uint8 sRGB."""
    encoded: NDArray[Any] = light.clip(0, 1)[..., None] ** _TONE * _WARM
    return (encoded * 255 + 0.5).astype(np.uint8)

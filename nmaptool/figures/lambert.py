"""The quick shading of small pictures: two lights, without shadows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Srgb
from nmaptool.core.grid import height_slopes
from nmaptool.options.preview import Light
from nmaptool.shading.lights import direction
from nmaptool.types.height import Height

# a low key light from the upper left, a weak fill from the right, a little ambient light
_LIGHTS = (Light(135.0, 38.0, 0.74), Light(15.0, 22.0, 0.22))
_AMBIENT = 0.09
_BACKDROP = 0.16
_TONE = 0.85  # lifts the shadows a little
_WARM = np.array([1.0, 0.975, 0.94])


def lambert(height: Height) -> Float64:
    """Return the (H, W) brightness in [0, 1] of each pixel, quickly; the backdrop outside the domain."""
    p, q = height_slopes(height.z_mm / height.pitch_mm)
    length = np.sqrt(1 + p * p + q * q)
    light = np.full(p.shape, _AMBIENT)
    for lamp in _LIGHTS:
        x, y, up = direction(lamp)
        light += lamp.strength * np.clip((-p * x - q * y + up) / length, 0, None)
    light[~height.domain] = _BACKDROP
    return light.clip(0, 1)


def in_colors(light: NDArray[Any]) -> Srgb:
    """Return (h, w) brightness as (h, w, 3) uint8 sRGB."""
    encoded: NDArray[Any] = light.clip(0, 1)[..., None] ** _TONE * _WARM
    return (encoded * 255 + 0.5).astype(np.uint8)

"""Linear light to the codes of a picture."""

from __future__ import annotations

from functools import cache

import numpy as np

from nmaptool.core.arrays import Float32, Srgb

_STEPS = 1 << 14
# light up to here is shown as it is; more is compressed towards white
_KNEE, _WHITE = 0.62, 4.0


def displayed(linear: Float32) -> Srgb:
    """(..., 3) uint8 sRGB of linear light; highlights are compressed instead of clipped.

    >>> displayed(np.float32([[0, 0.2140, 100]])).tolist()
    [[0, 127, 255]]
    """
    index = np.sqrt(linear.clip(0, _WHITE) * np.float32(1 / _WHITE)) * np.float32(_STEPS)
    return _table()[index.astype(np.int16)]


@cache
def _table() -> Srgb:
    """Codes of the square roots of light, from 0 to `_WHITE`."""
    light = ((np.arange(_STEPS + 1) + 0.5) / _STEPS) ** 2 * _WHITE
    light[0] = 0
    room = 1 - _KNEE
    over = (light - _KNEE).clip(0)
    # the shoulder leaves the knee with the slope of the line, and reaches white at `_WHITE`
    end = (_WHITE - _KNEE) / room
    x = over / room
    shoulder = _KNEE + room * x * (1 + x / end**2) / (1 + x)
    light = np.where(light > _KNEE, shoulder, light).clip(0, 1)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.asarray(code * 255 + 0.5, np.uint8)

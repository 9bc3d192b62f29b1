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
    return np.asarray(_codes(linear) + np.float32(0.5), np.uint8)


def dithered(linear: Float32) -> Srgb:
    """The same as `displayed` for (h, w, 3), with a fine pattern instead of steps in slow gradients."""
    rows, cols = linear.shape[:2]
    pattern = np.tile(_pattern(), (-(-rows // 8), -(-cols // 8)))[:rows, :cols, None]
    return np.asarray(_codes(linear) + pattern, np.uint8)


def _codes(linear: Float32) -> Float32:
    """Codes from 0 to 255 that are not rounded yet."""
    index = np.sqrt(linear.clip(0, _WHITE) * np.float32(1 / _WHITE)) * np.float32(_STEPS)
    return _table()[index.astype(np.int16)]


@cache
def _pattern() -> Float32:
    """(8, 8) thresholds of an ordered dither, between 0 and 1."""
    thresholds = np.zeros((1, 1))
    for _ in range(3):
        quarters = [[4 * thresholds, 4 * thresholds + 2], [4 * thresholds + 3, 4 * thresholds + 1]]
        thresholds = np.block(quarters)
    return np.asarray((thresholds + 0.5) / 64, np.float32)


@cache
def _table() -> Float32:
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
    return np.asarray(code * 255, np.float32)

"""The studio that metals mirror: soft boxes above a dark floor, by formulas.

Its parts stand around the plate as the first light does, so that the whole studio turns with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32


@dataclass(frozen=True)
class _Box:
    """A soft box: where it stands from the first light, in degrees, how bright it is, and how narrow."""

    around_deg: float
    elevation_deg: float
    brightness: float
    narrow: float
    is_key: bool = False


_BOXES = (
    _Box(0, 47, 2.7, 9.0, is_key=True),
    _Box(-80, 47, 0.75, 34.0),
    _Box(-105, 28, 0.3, 12.0),
    _Box(165, 24, 0.5, 16.0),
    _Box(75, 20, 0.28, 14.0),
)
_ZENITH, _HORIZON, _FLOOR = 0.3, 0.2, 0.2


def mirrored(toward: tuple[Any, Any, Any], roughness: float, azimuth_deg: float, key_share: Any) -> Float32:
    """Brightness of the studio in the directions that a surface mirrors.

    Parameters
    ----------
    toward : three arrays of the same shape
        x, y and z of unit vectors from the surface.
    roughness : float
        The studio is blurred by it.
    azimuth_deg : float
        Where the first light stands.
    key_share : array
        Share of the first light that the surface sees.

    Returns
    -------
    array of float32
    """
    x, y, z = toward
    up = np.clip((z + 0.15) * (1 / 1.15), 0, 1)
    out = _HORIZON + (_ZENITH - _HORIZON) * up
    out += (_FLOOR - _HORIZON) * np.clip(np.float32(0.5) - z * (1 / (0.3 + roughness)), 0, 1)
    for box in _BOXES:
        a, e = math.radians(azimuth_deg + box.around_deg), math.radians(box.elevation_deg)
        bx, by, bz = (np.float32(v) for v in (math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)))
        narrow = 1 / (1 / box.narrow + 0.5 * roughness**2)
        # a lobe keeps its light when it is blurred
        glow = np.exp((x * bx + y * by + z * bz - 1) * np.float32(narrow))
        glow *= np.float32(box.brightness * narrow / box.narrow)
        if box.is_key:
            glow *= np.float32(0.35) + np.float32(0.65) * key_share
        out += glow
    return np.asarray(out, np.float32)

"""Lamps, and how strongly they light a plate."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.options.preview import Light

# a lamp at this elevation lights a level plate as its strength says
_REFERENCE_DEG = 38.0
# photographers open the aperture for a raking light, but not fully: the plate becomes darker
_COMPENSATION = 0.65
_LOWEST_DEG = 3.0


def direction(light: Light) -> Float64:
    """(3,) float64 unit vector towards the lamp: x right, y up, z to the viewer."""
    a, e = math.radians(light.azimuth_deg), math.radians(light.elevation_deg)
    return np.array([math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)])


def power(light: Light) -> float:
    """Light on a surface that faces the lamp, relative to its strength on a level plate."""
    found, usual = (math.sin(math.radians(max(e, _LOWEST_DEG))) for e in (light.elevation_deg, _REFERENCE_DEG))
    return float(light.strength / usual * (usual / found) ** _COMPENSATION)

"""Cast shadows of a height field, by marching along the light's direction.

The grid is sheared so that the light travels down its columns. One pass then carries the upper edge of the shadow from
row to row, whatever its length, and heights are interpolated only once.
"""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.preview import Light
from nmaptool.shading.lights import direction

# the flattest light: a shadow is then 57 times as long as its caster is high
_LOWEST_DEG, _STEEPEST_DEG = 1.0, 89.0
LAMP_DEG = 3.0
_FAR_BELOW_MM = np.float32(-1e7)


def lit_share(z_mm: Float32, pitch_mm: float, light: Light, size_deg: float = LAMP_DEG) -> Float32:
    """Share of a lamp that each point sees above the horizon of a height field.

    Parameters
    ----------
    z_mm : (h, w) float32
        Heights on a square grid; there is nothing outside it.
    pitch_mm : float
    light : Light
    size_deg : float
        Angle that the lamp subtends: it makes the edges of shadows soft. Half of the lamp is seen where the shadow of a
        point-like lamp would end.

    Returns
    -------
    (h, w) float32
        0 in full shadow, 1 in full light. A surface is not in its own shadow where it merely turns away from the light.
    """
    x, y, _ = direction(light)
    # rows run down; turned so that the light comes from the first row, and from the left or straight ahead
    toward_row, toward_col = -y, x
    is_turned = abs(toward_col) > abs(toward_row) + 1e-9
    grid = z_mm.T if is_turned else z_mm
    major, minor = (toward_col, toward_row) if is_turned else (toward_row, toward_col)
    rows = slice(None, None, 1 if major <= 0 else -1)
    cols = slice(None, None, 1 if minor <= 0 else -1)
    out = np.empty(grid.shape, np.float32)
    shear = abs(minor / major) if abs(minor) > 1e-9 else 0.0
    _march(grid[rows, cols], out[rows, cols], shear, pitch_mm * math.hypot(1, shear), _tangents(light, size_deg))
    return out.T if is_turned else out


def _tangents(light: Light, size_deg: float) -> tuple[float, float]:
    """Tangents of the elevations of the lamp's upper and lower edge, around that of its middle."""
    elevation = math.radians(min(max(light.elevation_deg, _LOWEST_DEG), _STEEPEST_DEG))
    middle = math.tan(elevation)
    half = min(math.radians(size_deg / 2) / math.cos(elevation) ** 2, 0.5 * middle)
    return middle + half, middle - half


def _march(grid: Float32, out: Float32, shear: float, step_mm: float, tangents: tuple[float, float]) -> None:
    """Fill ``out``; the light comes from row 0 and moves right by ``shear`` columns per row."""
    rows, cols = grid.shape
    upper, lower = (np.float32(tangent * step_mm) for tangent in tangents)
    size, middle = upper - lower, (upper + lower) / 2
    whole = np.floor(np.arange(rows) * shear).astype(np.intp)
    part = (np.arange(rows) * shear - whole).astype(np.float32)
    # column j of the sheared grid is at column j - width + whole + part of the grid
    width = int(whole[-1]) + 2
    padded = np.full(cols + 2 * width, _FAR_BELOW_MM)
    share = np.ones(cols + 2 * width, np.float32)
    total = cols + width
    # the lower edge of the light above the caster of the shadow, and how many rows ago that was
    low = before = np.full(total, _FAR_BELOW_MM)
    age = np.zeros(total, np.float32)
    tiny = np.float32(0.02) * middle
    for row in range(rows):
        padded[width : width + cols] = grid[row]
        padded[width - 1], padded[width + cols] = grid[row, 0], grid[row, -1]
        start, t = int(whole[row]), part[row]
        here = padded[start : start + total]
        # weighted so that what is far below never rises by rounding
        here = (1 - t) * here + t * padded[start + 1 : start + 1 + total]
        low = low - lower
        age += 1
        spread = age * size
        hidden = low - here - spread / 2
        # a plane is lit up to its own neighbour: the edge of a shadow is at least one row wide on it
        ramp = np.maximum(middle + here - before, tiny)
        seen = (np.float32(0.5) - hidden / np.maximum(spread, ramp)).clip(0, 1)
        share[start : start + total] = seen
        lit = share[width : width + cols]
        out[row] = lit + t * (share[width - 1 : width - 1 + cols] - lit)
        higher = here >= low
        low = np.where(higher, here, low)
        age[higher] = 0
        before = here

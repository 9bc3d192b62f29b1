"""Ambient occlusion: how much of the sky each point of a height field sees."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.parallel import map_parallel

# offsets (rows, columns) in a quarter of the directions
_QUARTER = ((0, 1), (1, 2), (1, 1), (2, 1))
# how far the horizon is sought, as a share of the longer side, and how the steps to there grow
_REACH, _GROWTH = 0.09, 1.4
# from this distance on, heights are blurred
_FAR_PX, _FAR_BLUR_PX = 8.0, 2.5
_BAND = 64
# a larger picture is reduced to about this many pixels on its longer side: the sky varies slowly
_LONGEST_PX = 640
_BELOW = np.float32(-1e7)


def sky_share(z_mm: Float32, pitch_mm: float) -> Float32:
    """Share of the light of an even sky that reaches each point of a height field.

    It is the mean over the directions of the cosine squared of the horizon's elevation. That is 1 on a level plate and
    (1 + cos t) / 2 on a plane tilted by t.

    Parameters
    ----------
    z_mm : (h, w) float32
        There is nothing outside the grid.
    pitch_mm : float

    Returns
    -------
    (h, w) float32
        0 to 1.
    """
    import cv2

    rows, cols = z_mm.shape
    factor = min(1.0, _LONGEST_PX / max(rows, cols))
    small = (max(1, round(rows * factor)), max(1, round(cols * factor)))
    heights = z_mm if factor == 1 else cv2.resize(z_mm, small[::-1], interpolation=cv2.INTER_AREA)
    out = _sky(np.asarray(heights, np.float32), pitch_mm / factor)
    if factor < 1:
        out = cv2.resize(out, (cols, rows), interpolation=cv2.INTER_CUBIC)
    return np.asarray(out, np.float32).clip(0, 1)


def _steps(longer_px: int) -> list[int]:
    """Multiples of an offset, from the neighbour to the farthest, ever wider apart."""
    out, reach = [1], max(2, round(_REACH * longer_px))
    while out[-1] < reach:
        out.append(max(out[-1] + 1, round(out[-1] * _GROWTH)))
    return out


def _directions() -> list[tuple[int, int, float]]:
    """Offsets (rows, columns) that lie exactly on a direction, and the share of the circle for which each stands."""
    angles = [math.atan2(down, right) for down, right in _QUARTER]
    angles = [angles[-1] - math.tau / 4, *angles, math.tau / 4]
    out = []
    for place, (down, right) in enumerate(_QUARTER, start=1):
        share = (angles[place + 1] - angles[place - 1]) / 2 / math.tau
        out += [(*turned, share) for turned in ((down, right), (right, -down), (-down, -right), (-right, down))]
    return out


def _sky(z_mm: Float32, pitch_mm: float) -> Float32:
    import cv2

    rows, cols = z_mm.shape
    steps = _steps(max(rows, cols))
    margin = steps[-1]
    near = np.pad(z_mm, margin, constant_values=_BELOW)
    # far away, single peaks would cast rays in the directions that are looked at
    blurred = cv2.GaussianBlur(z_mm, (0, 0), _FAR_BLUR_PX, borderType=cv2.BORDER_REPLICATE)
    far = np.pad(np.asarray(blurred, np.float32), margin, constant_values=_BELOW)

    def seen(band: slice) -> Float32:
        here = z_mm[band]
        total = np.zeros(here.shape, np.float32)
        for down, right, share in _directions():
            length = math.hypot(down, right)
            steepest = np.zeros(here.shape, np.float32)
            for step in sorted({max(1, round(step / length)) for step in steps}):
                top, left = margin + band.start + step * down, margin + step * right
                padded = near if step * length < _FAR_PX else far
                rise = padded[top : top + len(here), left : left + cols] - here
                rise *= np.float32(1 / (pitch_mm * step * length))
                np.maximum(steepest, rise, out=steepest)
            steepest *= steepest
            steepest += 1
            total += np.float32(share) / steepest
        return total

    bands = [slice(top, min(top + _BAND, rows)) for top in range(0, rows, _BAND)]
    return np.concatenate(map_parallel(bands, seen))

"""Heights across a frame, from the edge of the plate to the inner side, as shares of its height."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64

# samples of a profile for each pixel, over which it is averaged
_FINE = 16
# share of the width of a bevel that is level, along the edge
_BEVEL_TOP = 0.15
# depths at which the highest point of a profile is sought
_CREST = 1001


@dataclass(frozen=True, eq=False)
class Cross:
    """What a frame's heights are computed from.

    Attributes
    ----------
    width_mm : float
        Of the frame.
    slope_mm : float
        Width of the slope on its inner side.
    pitch_mm : float
        Profiles are averaged over two pixels, so that edges between pixels have no steps.
    """

    width_mm: float
    slope_mm: float
    pitch_mm: float


def slope(depth_mm: Float64, slope_mm: float, pitch_mm: float) -> Float64:
    """A slope that rises from 0 to 1 within ``slope_mm`` around depth 0, with its edges rounded over a pixel."""
    half = max(slope_mm, pitch_mm) / 2
    return averaged(lambda depth: np.clip((depth + half) / (2 * half), 0, 1), depth_mm, half, pitch_mm)


def averaged(profile: Callable[[Float64], Float64], depth_mm: Float64, reach_mm: float, pitch_mm: float) -> Float64:
    """A profile, constant beyond ``reach_mm`` on both sides of 0, averaged over two pixels."""
    step = pitch_mm / _FINE
    # one step more than two pixels beyond the reach, so that both ends are means of constants
    count = int(np.ceil(reach_mm / step)) + 2 * _FINE + 1
    samples = profile(np.asarray((np.arange(-count, count) + 0.5) * step, np.float64))
    mean = np.convolve(samples, np.full(2 * _FINE, 0.5 / _FINE), "valid")
    out: Float64 = np.interp(depth_mm, (np.arange(len(mean)) + _FINE - count) * step, mean)
    return out


def half_round(share: Float64) -> Float64:
    """The height of a half circle from -1 to 1."""
    out: Float64 = np.sqrt(np.maximum(0.0, 1 - share**2))
    return out


def plain_profile(name: str, drawn: Float64 | None, cross: Cross, depth_mm: Float64) -> Float64:
    """Heights of a profile that is the same along the frame, at depths from the edge; 1 where it is highest."""
    width, ramp = cross.width_mm, cross.slope_mm

    def at(depth: Float64) -> Float64:
        share = np.clip(depth / width, 0, 1)
        if drawn is not None:
            found = np.where(depth > width, 0.0, np.interp(share, drawn[:, 0], drawn[:, 1]))
        elif name == "round":
            found = half_round(2 * share - 1)
        elif name == "bevel":
            found = np.clip((1 - share) / (1 - _BEVEL_TOP), 0, 1)
        else:
            found = np.clip((width - depth) / ramp, 0, 1)
        return np.asarray(found, np.float64)

    crest = averaged(at, np.linspace(0.0, width, _CREST), width, cross.pitch_mm).max()
    return averaged(at, depth_mm, width, cross.pitch_mm) / float(crest)

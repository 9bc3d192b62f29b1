"""Heights across a frame, from the edge of the plate to the inner side, as shares of its height."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.plates.distance import Curves
from nmaptool.plates.polygons import offset, outer_rings
from nmaptool.types.contours import Contours

# samples of a profile for each pixel, over which it is averaged
_FINE = 16
# share of the width of a rope or a row of beads that is a level rim along the edge
_RIM = 0.2
_BEVEL_TOP = 0.15
# beads: diameter by the width of their row, and distance by diameter
_BEAD = 0.94
_BEAD_SPACING = 1.06
# rope: length of a strand along it by its width, how far it winds across, how deep the grooves are
_STRAND = 0.62
_WIND = 0.55
_GROOVE = 0.42


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
    samples = profile((np.arange(-count, count) + 0.5) * step)
    mean = np.convolve(samples, np.full(2 * _FINE, 0.5 / _FINE), "valid")
    out: Float64 = np.interp(depth_mm, (np.arange(len(mean)) + _FINE - count) * step, mean)
    return out


def plain_profile(name: str, drawn: Float64 | None, cross: Cross, depth_mm: Float64) -> Float64:
    """Heights of a profile that is the same along the frame, at depths from the edge."""
    width, ramp = cross.width_mm, cross.slope_mm

    def at(depth: Float64) -> Float64:
        share = np.clip(depth / width, 0, 1)
        if drawn is not None:
            return np.where(depth > width, 0.0, np.interp(share, drawn[:, 0], drawn[:, 1]))
        if name == "round":
            return np.sqrt(np.maximum(0.0, 1 - (2 * share - 1) ** 2))
        if name == "bevel":
            return np.clip((1 - share) / (1 - _BEVEL_TOP), 0, 1)
        return np.clip((width - depth) / ramp, 0, 1)

    return averaged(at, depth_mm, width, cross.pitch_mm)


def rope(cross: Cross, depth_mm: Float64, along_mm: Float64, length_mm: float) -> Float64:
    """A level rim, and inside it a twisted rope; strands repeat a whole number of times along ``length_mm``."""
    rim, width = _rim_of(cross)
    across = np.clip(2 * (depth_mm - rim) / width - 1, -1, 1)
    body = np.sqrt(np.maximum(0.0, 1 - across**2))
    count = max(3, round(length_mm / (_STRAND * width)))
    turn = along_mm / length_mm * count + _WIND * np.arcsin(across) / (np.pi / 2)
    strand = 2 * (turn - np.floor(turn)) - 1
    groove = 1 - np.sqrt(np.maximum(0.0, 1 - 0.96 * strand**2))
    out: Float64 = np.maximum(_rim_profile(cross, rim, depth_mm), body * (1 - _GROOVE * groove))
    return out


def beads(cross: Cross, depth_mm: Float64, points_mm: Float64, outline: Contours) -> Float64:
    """A level rim, and inside it a row of half spheres at equal distances."""
    from scipy.spatial import cKDTree  # takes long to load

    rim, width = _rim_of(cross)
    radius = _BEAD * width / 2
    line = outer_rings(offset(outline, -(rim + width / 2)))
    centres = np.concatenate([_evenly(ring, 2 * radius * _BEAD_SPACING) for ring in line.rings])
    distance, _ = cKDTree(centres).query(points_mm.reshape(-1, 2), distance_upper_bound=radius, workers=-1)
    share = np.minimum(distance / radius, 1.0).reshape(depth_mm.shape)
    out: Float64 = np.maximum(_rim_profile(cross, rim, depth_mm), np.sqrt(np.maximum(0.0, 1 - share**2)))
    return out


def _rim_of(cross: Cross) -> tuple[float, float]:
    """Width of the level rim along the edge, and of what lies inside it."""
    rim = _RIM * cross.width_mm
    return rim, cross.width_mm - rim


def _rim_profile(cross: Cross, rim: float, depth_mm: Float64) -> Float64:
    ramp = min(cross.slope_mm, rim / 2)
    return averaged(lambda depth: np.clip((rim - depth) / ramp, 0, 1), depth_mm, rim, cross.pitch_mm)


def _evenly(ring: Float64, spacing_mm: float) -> Float64:
    """Points on a ring at equal distances near ``spacing_mm``, from its highest point on."""
    ring = np.roll(ring, -int(ring[:, 1].argmax()), axis=0)
    closed = np.concatenate([ring, ring[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    count = max(3, int(along[-1] / spacing_mm))
    place = np.arange(count) * along[-1] / count
    x, y = (np.interp(place, along, each) for each in closed.T)
    return np.column_stack([x, y])


def length_of(outline: Contours) -> float:
    """The length of the outer ring."""
    return Curves(outline, 1.0).lengths_mm[0]

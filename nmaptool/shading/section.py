"""A cut through a height field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import UsageError
from nmaptool.core.units import Offset
from nmaptool.options.preview import Axis
from nmaptool.types.contours import Contours
from nmaptool.types.height import Height


@dataclass(frozen=True, eq=False)
class Section:
    """The profile along a cut.

    Attributes
    ----------
    axis : str
        The axis that is constant along the cut: ``x`` or ``y``.
    at_mm : float
        Its place, from the lower left corner.
    along_mm, z_mm : (n,) float64
        The profile from left to right, or from bottom to top. Heights are NaN where there is no surface; at a vertical
        wall, two points have the same place.
    """

    axis: Axis
    at_mm: float
    along_mm: Float64
    z_mm: Float64


def section(height: Height, axis: Axis, place: Offset) -> Section:
    """Cut a height field along a line.

    Parameters
    ----------
    height : Height
    axis : str
        The axis that is constant along the cut.
    place : Offset
        Its place; per cent are of that side of the picture.

    Returns
    -------
    Section

    Raises
    ------
    UsageError
        If the place is not inside the picture, or there is no surface.
    """
    rows, cols = height.frame.shape
    pitch = height.pitch_mm
    side = cols if axis == "x" else rows
    at_px = place.to_px(pitch, side)
    if not 0 <= at_px <= side:
        raise UsageError(
            f"`section='{axis}={place}'`: lies at {at_px * pitch:.4g} mm; the relief reaches from 0 to "
            f"{side * pitch:.4g} mm along {axis}"
        )
    sheets, domain, raised = _turned(height, axis)
    # rows of the arrays now run along the constant axis, from 0 up
    row = min(int(at_px), side - 1)
    part = at_px - row
    lines = [np.asarray((1 - part) * sheet[row] + part * sheet[row + 1]) for sheet in sheets]
    on_motif = raised[row]
    left, right = (np.where(on_motif, lines[0][cut], lines[1][cut]) for cut in (slice(None, -1), slice(1, None)))
    z = np.stack([left, right], axis=1)
    z[~domain[row]] = np.nan
    along = np.arange(len(lines[0]), dtype=np.float64) * pitch
    ends = np.stack([along[:-1], along[1:]], axis=1).ravel()
    profile = z.ravel()
    if height.outline is not None:
        ends, profile = _within(height.outline, axis, at_px * pitch, along, lines[1])
    if not np.isfinite(profile).any():
        raise UsageError(f"`section='{axis}={place}'`: meets no surface at {at_px * pitch:.4g} mm")
    return Section(axis, at_px * pitch, ends, profile)


def _turned(height: Height, axis: Axis) -> tuple[tuple[Any, Any], Any, Any]:
    """Heights of the motif and of the plate, the domain and the motif, with rows along the constant axis."""
    motif = np.ones_like(height.domain) if height.raised is None else height.raised

    def turn(values: Any) -> Any:
        upward = values[::-1]
        return upward.T if axis == "x" else upward

    sheets = turn(height.z_mm), turn(height.plate_mm())
    return sheets, turn(height.domain), turn(motif)


def _within(outline: Contours, axis: Axis, at_mm: float, along: Float64, z_mm: Float64) -> tuple[Float64, Float64]:
    """The profile between the points where the cut crosses an outline, NaN between its parts."""
    fixed, moving = (0, 1) if axis == "x" else (1, 0)
    crossings = []
    for ring in outline.rings:
        following = np.roll(ring, -1, axis=0)
        crosses = (ring[:, fixed] > at_mm) != (following[:, fixed] > at_mm)
        a, b = ring[crosses], following[crosses]
        share = (at_mm - a[:, fixed]) / (b[:, fixed] - a[:, fixed])
        crossings.append(a[:, moving] + share * (b[:, moving] - a[:, moving]))
    edges = np.sort(np.concatenate(crossings)) if crossings else np.empty(0)
    places, heights = [np.array([along[0]])], [np.array([np.nan])]
    for first, last in edges.reshape(-1, 2):
        inside = along[(along > first) & (along < last)]
        part = np.concatenate([[first], inside, [last]])
        places += [part, part[-1:]]
        heights += [np.interp(part, along, z_mm), np.array([np.nan])]
    return np.concatenate(places), np.concatenate(heights)

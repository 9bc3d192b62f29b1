"""Brush strokes on a grey picture: a mask, or weights of mu, beta or delta."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import UsageError

Tool = Literal["paint", "erase", "smooth", "fill"]
MOST_POINTS = 5000
_LARGEST_PX = 100_000.0
# greys that differ by less belong to the same area, for "fill"
_SAME = 0.02


@dataclass(frozen=True)
class Brush:
    """How a stroke changes the picture.

    Parameters
    ----------
    tool : str
        "paint" moves greys towards ``value``, "erase" towards the value before anything was painted, "smooth" towards
        their surroundings; "fill" paints the area of equal grey around the first point.
    size : float
        Diameter in px of the picture, at full pressure.
    value : float
        0 is black, 1 is white.
    hardness : float
        Share of the radius inside which the brush acts fully; from there to the rim it fades.
    opacity : float
        Share of the way to the new grey, however often a stroke crosses itself.

    Raises
    ------
    UsageError
        If a value is out of range.
    """

    tool: Tool = "paint"
    size: float = 40.0
    value: float = 0.0
    hardness: float = 0.5
    opacity: float = 1.0

    def __post_init__(self) -> None:
        if self.tool not in get_args(Tool):
            raise UsageError(f"the brush {self.tool!r} is not one of {', '.join(get_args(Tool))}")
        if not 0 < self.size <= _LARGEST_PX:
            raise UsageError(f"a brush of {self.size:g} px: its size must be more than 0, at most {_LARGEST_PX:g} px")
        for name in ("value", "hardness", "opacity"):
            given = getattr(self, name)
            if not 0 <= given <= 1:
                raise UsageError(f"a brush with a {name} of {given:g}: it must lie between 0 and 1")


def stroke(grey: Float32, brush: Brush, points: Float64, erased: Float32 | float) -> Float32:
    """Return a picture after a stroke.

    Parameters
    ----------
    grey : (H, W) float32 in [0, 1]
    brush : Brush
    points : (N, 3) float64
        Across and down in px from the top left corner, and pressure in [0, 1], which scales the size.
    erased : (H, W) float32 or float
        What "erase" goes back to.

    Returns
    -------
    (H, W) float32
        A new array.

    Raises
    ------
    UsageError
        If there are no points or too many, or they are not finite.
    """
    if points.ndim != 2 or points.shape[1:] != (3,) or not 1 <= len(points) <= MOST_POINTS:
        raise UsageError(f"a stroke has 1 to {MOST_POINTS} points of three numbers")
    if not np.isfinite(points).all() or np.abs(points).max() > _LARGEST_PX:
        raise UsageError("a stroke left the picture; paint again")
    if brush.tool == "fill":
        share = brush.opacity * _area(grey, points[0])
        return _mixed(grey, share, np.float32(brush.value))
    share = np.float32(brush.opacity) * reach_of(grey.shape, brush, points)
    if brush.tool == "smooth":
        sigma = max(brush.size / 6, 1.0)
        return _mixed(grey, share, cv2.GaussianBlur(grey, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE))
    return _mixed(grey, share, erased if brush.tool == "erase" else np.float32(brush.value))


def _mixed(grey: Float32, share: Float32, target: Float32 | np.float32 | float) -> Float32:
    return np.clip(grey + share * (np.asarray(target, np.float32) - grey), 0, 1).astype(np.float32)


def reach_of(shape: tuple[int, ...], brush: Brush, points: Float64) -> Float32:
    """Return how strongly a stroke acts on each pixel: (H, W) float32 in [0, 1]."""
    share = np.zeros(shape, np.float32)
    ends = np.vstack([points, points[-1:]])
    for start, end in itertools.pairwise(ends):
        _segment(share, brush, start, end)
    return share


def _segment(share: Float32, brush: Brush, start: Float64, end: Float64) -> None:
    """Draw one segment, whose width goes from that of its first point to that of its last, into ``share``."""
    radii = np.maximum(0.5 * brush.size * np.clip([start[2], end[2]], 0, 1), 0.5)
    reach = radii.max() + 1
    low = np.floor(np.minimum(start[:2], end[:2]) - reach).astype(int)
    high = np.ceil(np.maximum(start[:2], end[:2]) + reach).astype(int)
    rows, cols = share.shape
    left, top = max(low[0], 0), max(low[1], 0)
    right, bottom = min(high[0], cols), min(high[1], rows)
    if left >= right or top >= bottom:
        return
    x = np.arange(left, right, dtype=np.float32)[None, :] + np.float32(0.5 - start[0])
    y = np.arange(top, bottom, dtype=np.float32)[:, None] + np.float32(0.5 - start[1])
    way = (end[:2] - start[:2]).astype(np.float32)
    squared = float(way @ way)
    along = np.clip((x * way[0] + y * way[1]) / squared, 0, 1) if squared > 0 else np.float32(0)
    distance = np.hypot(x - along * way[0], y - along * way[1])
    radius = radii[0] + along * np.float32(radii[1] - radii[0])
    # a rim of at least one px, so that hard brushes have no steps
    soft = np.maximum(radius * np.float32(1 - brush.hardness), 1)
    t = np.clip((radius + 0.5 - distance) / soft, 0, 1)
    part = share[top:bottom, left:right]
    np.maximum(part, t * t * (3 - 2 * t), out=part)


def _area(grey: Float32, point: Float64) -> Float32:
    """(H, W) float32: 1 on the connected area of equal grey around a point."""
    rows, cols = grey.shape
    x, y = int(np.clip(point[0], 0, cols - 1)), int(np.clip(point[1], 0, rows - 1))
    found = np.zeros((rows + 2, cols + 2), np.uint8)
    flags = 4 | cv2.FLOODFILL_MASK_ONLY | cv2.FLOODFILL_FIXED_RANGE | (1 << 8)
    cv2.floodFill(grey.copy(), found, (x, y), 0, _SAME, _SAME, flags)
    return found[1:-1, 1:-1].astype(np.float32)

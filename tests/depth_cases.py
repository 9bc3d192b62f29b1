"""Depth images of analytic surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import nmaptool as nm
from nmaptool.io.pictures.metadata import depth_facts


def picture(values: Any, bits: int = 32, **more: Any) -> nm.RasterImage:
    """A grey RasterImage of (H, W) values; integer codes are rounded."""
    kinds = {8: np.uint8, 16: np.uint16, 32: np.float32}
    array = np.asarray(values)
    codes = array.astype(np.float32) if bits == 32 else np.floor(array + 0.5).astype(kinds[bits])
    facts = depth_facts(more.get("attributes", {}))  # as when a file is read
    return nm.RasterImage(codes[..., None], ("Y",), bits=bits, depth_facts=facts, **more)


def coded(heights: Any, bits: int) -> tuple[nm.RasterImage, str]:
    """Heights in px (from 0 up) encoded over the full range of codes, and the depth scale that restores them."""
    top = float(np.max(heights))
    if bits == 32:
        return picture(heights), f"{np.ptp(heights) if top > 1 else 1}px"
    return picture(np.asarray(heights) / top * (2**bits - 1), bits), f"{top}px"


def normals_of_slopes(p: Any, q: Any) -> Any:
    """(..., 3) float64 unit normals from slopes dz/dx and dz/dy, y up."""
    out = np.stack(np.broadcast_arrays(-np.asarray(p), -np.asarray(q), 1.0), axis=-1)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def angles(first: Any, second: Any) -> Any:
    """Angles in degrees between unit vectors."""
    half = np.linalg.norm(np.asarray(first, float) - second, axis=-1) / 2
    return np.degrees(2 * np.arcsin(half.clip(0, 1)))


def grid(rows: int, cols: int) -> tuple[Any, Any]:
    """x (right) and y (up) of the pixel centres, in px from the image centre."""
    y, x = np.mgrid[:rows, :cols]
    return x + 0.5 - cols / 2, rows / 2 - y - 0.5


@dataclass(frozen=True)
class Ball:
    """A sphere in front of a plane: heights, the sphere's share of each pixel, its normals and slopes."""

    heights: Any
    cover: Any
    normals: Any
    slope: Any

    @property
    def inside(self) -> Any:
        """Pixels of which the sphere covers more than half."""
        return self.cover >= 0.5


def ball(side: int, radius: float, gap: float, over: int = 1) -> Ball:
    """A sphere whose outline is ``gap`` px in front of a plane, rendered with over x over samples per pixel."""
    x, y = grid(side * over, side * over)
    x, y = x / over - 0.3, y / over + 0.17
    inside = x * x + y * y < radius**2
    z = np.where(inside, gap + np.sqrt(np.maximum(radius**2 - x * x - y * y, 0)), 0.0)
    heights, cover = (v.reshape(side, over, side, over).mean(axis=(1, 3)) for v in (z, inside))
    x, y = grid(side, side)
    x, y = x - 0.3, y + 0.17
    r = np.minimum(np.hypot(x, y), radius - 1e-3)
    up = np.sqrt(radius**2 - r**2)
    return Ball(heights, cover, normals_of_slopes(-x / up, -y / up), r / up)

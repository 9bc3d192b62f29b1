"""Solids as fields that are negative inside, and smooth unions of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mesh_parts import Array

Point = Sequence[float]


def join(a: Array, b: Array, soft: float) -> Array:
    """Union with a fillet ``soft`` mm wide."""
    blend = (soft - np.abs(a - b)).clip(0, None)
    return np.minimum(a, b) - blend * blend / (4 * soft)


def carve(a: Array, b: Array, soft: float) -> Array:
    """``a`` without ``b``."""
    return -join(-a, b, soft)


def ball(p: Array, centre: Point, radii: Point | float) -> Array:
    """A sphere or an ellipsoid."""
    r = np.broadcast_to(np.asarray(radii, dtype=float), (3,))
    q = (p - np.asarray(centre, dtype=float)) / r
    size = np.sqrt((q * q).sum(axis=1)) + 1e-9
    return size * (size - 1) / (np.sqrt(((q / r) ** 2).sum(axis=1)) + 1e-9)


def rod(p: Array, a: Point, b: Point, start: float, end: float) -> Array:
    """A tapered round rod from a to b."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    t = ((p - a) @ (b - a) / ((b - a) @ (b - a))).clip(0, 1)
    off = p - a - t[:, None] * (b - a)
    return np.sqrt((off * off).sum(axis=1)) - start - (end - start) * t

"""Procedural textures in millimetres: the veins of marble, the grain of walnut."""

from __future__ import annotations

from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.materials import Material
from nmaptool.shading.field import Field

_CELLS = 128
_GREY_VEIN = np.array([0.43, 0.44, 0.46], np.float32)
_LATE_WOOD = np.array([0.062, 0.028, 0.014], np.float32)
_EARLY_WOOD = np.array([0.33, 0.185, 0.095], np.float32)


def colored(field: Field, material: Material) -> Float32:
    """The material's colour: (3,) float32 if it is the same everywhere, else (h, w, 3)."""
    rows, cols = field.shape
    x = (np.arange(cols, dtype=np.float32) + np.float32(0.5)) * np.float32(field.pitch_mm)
    y = (np.arange(rows, 0, -1, dtype=np.float32) - np.float32(0.5)) * np.float32(field.pitch_mm)
    x, y = (np.ascontiguousarray(v) for v in np.broadcast_arrays(x[None, :], y[:, None]))
    return pattern(material, x, y, field.centers_mm, is_tall=rows > cols)


def pattern(material: Material, x: Any, y: Any, z: Any, *, is_tall: bool = False) -> Float32:
    """The material's colour at points of a picture.

    Parameters
    ----------
    material : Material
    x, y, z : (h, w) float32
        In mm.
    is_tall : bool
        Whether grain runs along y.

    Returns
    -------
    (3,) or (h, w, 3) float32
        One colour if it is the same everywhere.
    """
    plain = np.array(material.color, np.float32)
    if material.pattern == "none":
        return plain
    if material.pattern == "marble":
        return _marble(x, y, z, plain)
    return _walnut(y, x, z, plain) if is_tall else _walnut(x, y, z, plain)


def noise(x: Any, y: Any, seed: int) -> Float32:
    """Smooth noise from -1 to 1 that varies over about one unit, the same for the same place and seed.

    Parameters
    ----------
    x, y : (h, w) float32
    seed : int
    """
    import cv2

    grid = np.random.default_rng(seed).uniform(-1, 1, (_CELLS, _CELLS)).astype(np.float32)
    u, v = (each % np.float32(_CELLS) for each in (x, y))
    return np.asarray(cv2.remap(grid, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP), np.float32)


def _marble(x: Any, y: Any, z: Any, plain: Float32) -> Float32:
    # veins run along one direction and wander; carving cuts through them
    bent_x = x + 7 * noise(x / 26, y / 26, 1) + 1.5 * noise(x / 6.1, y / 6.1, 2)
    bent_y = y + 7 * noise(x / 26, y / 26, 3) + 1.5 * noise(x / 6.1, y / 6.1, 4) + z
    across, along = (bent_x * 0.8 + bent_y * 0.6), (bent_y * 0.8 - bent_x * 0.6)
    cloud = np.float32(0.5) + np.float32(0.5) * noise(across / 17, along / 29, 7)
    share: Any = 0
    for seed, wide, long, sharp, depth in ((5, 21, 64, 4.5, 0.8), (6, 13, 41, 8.0, 0.5)):
        away = np.abs(noise(across / wide, along / long, seed))
        # a crisp line in a soft shade of its own
        line, shade = (np.maximum(1 - away * factor, 0) for factor in (sharp, sharp / 3))
        share = share + depth * (0.6 * line**3 + 0.4 * shade**2) * cloud
    share += 0.1 * cloud
    return np.asarray(plain + share.clip(0, 1)[..., None].astype(np.float32) * (_GREY_VEIN - plain), np.float32)


def _walnut(along: Any, across: Any, z: Any, plain: Float32) -> Float32:
    # rings around a heart that lies deep below the board and wanders; carving cuts through them
    bent = across + 2.6 * noise(along / 61, across / 23, 11) + 0.5 * noise(along / 19, across / 7, 12)
    radius = np.sqrt((bent - 9) ** 2 + (z - 26) ** 2)
    phase = radius / 2.9 + 0.35 * noise(along / 90, radius / 3, 13)
    ring = phase - np.floor(phase)
    late = ring**3 * np.clip((1 - ring) * 9, 0, 1)
    streak = noise(along / 31, radius / 0.55, 14)
    fibre = noise(along / 6.5, bent / 0.16, 15)
    pores = np.clip(noise(along / 3.4, bent / 0.11, 16) - 0.55, 0, 1) * (0.4 + 0.6 * (1 - ring))
    tone = (0.75 * late + 0.24 * streak + 0.16 * fibre + 0.9 * pores).astype(np.float32)
    light = plain + np.clip(-tone, 0, 1)[..., None] * (_EARLY_WOOD - plain)
    return np.asarray(light + np.clip(tone, 0, 1)[..., None] * (_LATE_WOOD - light), np.float32)

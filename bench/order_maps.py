"""Maps with known normals, and their storage in every order and sign of the axes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

import nmaptool as nm

_SIDE = 160


class TrueMap(NamedTuple):
    """Normals (H, W, 3) float32 in eye space, and the motif (H, W) bool; everything if the map has no outline."""

    name: str
    normals: Any
    motif: Any


def from_heights(name: str, heights: Any, motif: Any = None) -> TrueMap:
    """The map of a surface: heights in px, row 0 on top."""
    down, across = np.gradient(heights)
    normals = np.dstack([-across, down, np.ones_like(heights)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    motif = np.ones(heights.shape, bool) if motif is None else motif
    normals[~motif] = (0, 0, 1)
    return TrueMap(name, normals.astype(np.float32), motif)


def analytic() -> list[TrueMap]:
    """Seven raised motifs with an outline."""
    y, x = np.mgrid[-1 : 1 : _SIDE * 1j, -1 : 1 : _SIDE * 1j]
    r, size = np.hypot(x, y), _SIDE / 2
    cosine = np.cos(np.pi * r.clip(0, 1))
    bumps = 0.03 * np.sin(9 * x + 4 * y) * np.cos(11 * y - 2 * x)
    return [
        from_heights("sphere", np.sqrt(np.maximum(0, 0.81 - r**2)) * size, r < 0.88),
        from_heights("cone", -r * size / 2, r < 0.85),
        from_heights("ellipsoid", np.sqrt(np.maximum(0, 1 - (x / 0.9) ** 2 - (y / 0.6) ** 2)) * size / 2, _egg(x, y)),
        from_heights("ring", np.sqrt(np.maximum(0, 0.06 - (r - 0.6) ** 2)) * size, abs(r - 0.6) < 0.23),
        from_heights("egg", np.maximum(0, 1 - (x / 0.8) ** 2 - (y / 0.7) ** 2) ** 0.7 * size / 2, _egg(x, y)),
        from_heights("mound", (cosine + bumps) * size / 3, r < 0.9),
        from_heights("bust", bust() * size, bust() > 0.02),
    ]


def _egg(x: Any, y: Any) -> Any:
    return (x / 0.8) ** 2 + (y / 0.55) ** 2 < 0.95


def bust() -> Any:
    """A head on shoulders: heights in half sides of the picture, 0 outside."""
    y, x = np.mgrid[-1 : 1 : _SIDE * 1j, -1 : 1 : _SIDE * 1j]

    def ellipsoid(at_x: float, at_y: float, wide: float, tall: float, deep: float) -> Any:
        inside = 1 - ((x - at_x) / wide) ** 2 - ((y - at_y) / tall) ** 2
        return deep * np.sqrt(np.maximum(0, inside))

    head, neck, chest = (
        ellipsoid(0, -0.3, 0.42, 0.52, 0.5),
        ellipsoid(0, 0.3, 0.2, 0.4, 0.25),
        ellipsoid(0, 0.85, 0.75, 0.42, 0.35),
    )
    nose = 0.12 * np.exp(-((x / 0.07) ** 2) - ((y + 0.22) / 0.14) ** 2)
    eyes = sum(-0.05 * np.exp(-(((x - side) / 0.09) ** 2) - ((y + 0.36) / 0.06) ** 2) for side in (-0.17, 0.17))
    body = np.maximum(np.maximum(head, neck), chest)
    return np.where(body > 0, cv2.GaussianBlur(body + (nose + eyes) * (head > 0.1), (0, 0), 1.0), 0)


def textures() -> list[TrueMap]:
    """Seven full pictures, as games use them."""
    y, x = np.mgrid[0:_SIDE, 0:_SIDE].astype(float)
    rng = np.random.default_rng(7)
    cells = rng.random((40, 2)) * _SIDE
    near = np.min([np.hypot(x - a, y - b) for a, b in cells], axis=0)
    letters = np.zeros((_SIDE, _SIDE), np.uint8)
    cv2.putText(letters, "CARVE", (6, 95), cv2.FONT_HERSHEY_TRIPLEX, 1.5, 255, 3)
    bricks = ((y % 32 > 3) & ((x + 16 * ((y // 32) % 2)) % 64 > 3)).astype(float)
    rough = cv2.GaussianBlur(rng.normal(size=(_SIDE, _SIDE)), (0, 0), 4) * 30
    return [
        from_heights("stones", -np.minimum(near, 14) * 0.6),
        from_heights("letters", cv2.GaussianBlur(letters / 255.0, (0, 0), 2) * 6),
        from_heights("bricks", cv2.GaussianBlur(bricks, (0, 0), 1.2) * 4),
        from_heights("rivets", np.sqrt(np.maximum(0, 100 - (x % 32 - 16) ** 2 - (y % 32 - 16) ** 2))),
        from_heights("waves", 4 * np.sin(x / 9) * np.cos(y / 14)),
        from_heights("rough", rough),
        from_heights("scales", np.hypot((x % 32) - 16, y % 24) * 0.3),
    ]


def baked(folder: Path) -> Iterator[TrueMap]:
    """The original maps of the sample meshes, seen from two sides."""
    for path in sorted(folder.glob("*.ply")):
        mesh = nm.read_mesh(path)
        for view in ("front", "left"):
            original = nm.bake(mesh, nm.BakeOptions(size="240x240", view=view)).original
            yield TrueMap(f"{path.stem}, {view}", original.normals, original.foreground)


class Stored(NamedTuple):
    """A map stored in some order: 8-bit codes, and the swizzle that reads them."""

    pixels: Any
    swizzle: str


def storages(true: TrueMap) -> Iterator[Stored]:
    """The map in all 48 orders and signs of its axes; the motif is in alpha if there is an outline."""
    for axes in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            vectors = np.dstack([sign * true.normals[..., axis] for axis, sign in zip(axes, signs, strict=True)])
            codes = np.floor((vectors + 1) / 2 * 255 + 0.5).astype(np.uint8)
            if not true.motif.all():
                codes = np.dstack([codes, np.where(true.motif, 255, 0).astype(np.uint8)])
            places = [axes.index(axis) for axis in range(3)]
            yield Stored(codes, ",".join(("-" if signs[at] < 0 else "") + "rgb"[at] for at in places))

"""Patterns that displace a surface: solid ones as functions of position, flat ones of coordinates along it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from surface import Array, Surface

Rng = np.random.Generator
Ornament = Callable[[Surface, Rng], Array]  # a height for each vertex; the catalogue gives it its steepness
Flat = Callable[[Array, Array], Array]  # over u and v in waves

LETTERS = {
    "A": "01110100011000111111100011000110001",
    "E": "11111100001000011110100001000011111",
    "L": "10000100001000010000100001000011111",
    "M": "10001110111010110101100011000110001",
    "N": "10001110011010110011100011000110001",
    "O": "01110100011000110001100011000101110",
    "R": "11110100011000111110101001001010001",
    "S": "01111100001000001110000010000111110",
    "T": "11111001000010000100001000010000100",
    "V": "10001100011000110001100010101000100",
}


def waves(points: Array, wave: float, rng: Rng, count: int = 48) -> Array:
    """Noise of one size: plane waves of one wavelength in all directions."""
    way = rng.normal(size=(count, points.shape[1]))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way *= rng.uniform(0.8, 1.25, (count, 1))
    phase = rng.uniform(0, 2 * np.pi, count)
    return np.cos(2 * np.pi / wave * points @ way.T + phase).sum(axis=1) * np.sqrt(2 / count)


def noise(wave: float) -> Ornament:
    """Bumps and hollows of one size, in edges."""
    return lambda s, rng: waves(s.vertices, wave * s.edge, rng)


def fractal(wave: float, octaves: int = 3, gain: float = 0.5) -> Ornament:
    """Noise in several sizes, each half the previous one."""

    def heights(s: Surface, rng: Rng) -> Array:
        return sum((gain**k * waves(s.vertices, wave * s.edge / 2**k, rng) for k in range(octaves)), np.zeros(1))

    return heights


def hammered(wave: float) -> Ornament:
    """Hollows that meet in ridges."""
    return lambda s, rng: np.abs(waves(s.vertices, 1.6 * wave * s.edge, rng))


def chased(wave: float, width: float = 0.3) -> Ornament:
    """Adjacent winding grooves; ``width`` is a fraction of a wave."""

    def heights(s: Surface, rng: Rng) -> Array:
        way = rng.normal(size=3) * (0.4, 1, 0.4)
        phase = s.vertices @ (way / np.linalg.norm(way)) / (wave * s.edge)
        phase = phase + 0.45 * waves(s.vertices, 5 * wave * s.edge, rng, 24)
        off = np.abs((phase % 1) - 0.5) * 2
        return -np.exp(-((off / (2 * width)) ** 2))

    return heights


def locks(axis: tuple[float, float, float], count: int, twist: float = 0.0, sway: float = 0.3) -> Ornament:
    """Round locks with creases between them, combed away from an axis through the origin."""

    def heights(s: Surface, rng: Rng) -> Array:
        a = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        u = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        u /= np.linalg.norm(u)
        along = s.vertices @ a
        turn = np.arctan2(s.vertices @ np.cross(a, u), s.vertices @ u) / (2 * np.pi)
        phase = count * turn + twist * along + sway * waves(s.vertices, 40 * s.edge, rng, 12)
        return np.abs(np.cos(np.pi * phase)) ** 0.8

    return heights


def laid(pattern: Flat, wave: float, tall: float = 1.0) -> Ornament:
    """A flat pattern along a surface's own coordinates; a wave is ``tall`` times as long as wide.

    A closed form has an even number of waves around it.
    """

    def heights(s: Surface, rng: Rng) -> Array:
        assert s.uv is not None
        size = wave * s.edge
        across = s.period / (2 * max(1, round(s.period / size / 2))) if s.period else size
        return pattern(s.uv[:, 0] / across, s.uv[:, 1] / (size * tall))

    return heights


def knurl(u: Array, v: Array) -> Array:
    """Pyramids between two runs of slanting grooves."""
    return np.minimum(np.abs((u + v) % 1 - 0.5), np.abs((u - v) % 1 - 0.5))


def flutes(u: Array, v: Array) -> Array:
    """Hollows side by side."""
    return -np.sqrt((1 - (2 * (u % 1) - 1) ** 2).clip(0, None))


def weave(u: Array, v: Array) -> Array:
    """Interwoven bands."""
    warp = np.abs(np.sin(np.pi * u)) * (1.2 + np.cos(np.pi * (v + np.floor(u))))
    weft = np.abs(np.sin(np.pi * v)) * (1.2 - np.cos(np.pi * (u + np.floor(v))))
    return np.maximum(warp, weft)


def bricks(u: Array, v: Array) -> Array:
    """Courses of stones, each offset by half a stone, with joints between them."""
    row = np.floor(v)
    across = np.abs((u / 2 + row / 2) % 1 - 0.5) * 4
    along = np.abs(v % 1 - 0.5) * 2
    edge = np.minimum((2 - across) * 1.0, 1 - along)
    tone = 0.25 * np.sin(12.9 * np.floor(u / 2 + row / 2) + 78.2 * row)
    return (edge / 0.35).clip(0, 1) * (1 + tone)


def rope(u: Array, v: Array) -> Array:
    """Strands that go around."""
    return np.abs(np.sin(np.pi * (u + v)))


def rings(u: Array, v: Array) -> Array:
    return np.abs(np.sin(np.pi * v)) ** 0.7


def tiles(u: Array, v: Array) -> Array:
    """Roof tiles: rows that end in a drop, each offset by half a tile."""
    row = np.floor(v)
    return (
        (0.8 + 0.2 * (v % 1))
        * ((1 - v % 1) / 0.25).clip(0, 1)
        * (np.abs(np.sin(np.pi * (u + row / 2))) / 0.4).clip(0, 1)
    )


def writing(text: str) -> Flat:
    """Repeated raised letters, one per wave; each line starts two letters later."""
    bitmaps = [np.pad(np.array(list(LETTERS[c]), float).reshape(7, 5)[::-1], ((2, 1), (1, 1))) for c in text]
    line = gaussian_filter(np.kron(np.hstack(bitmaps), np.ones((4, 4))), 1.6, mode="wrap")

    def pattern(u: Array, v: Array) -> Array:
        row = np.floor(v)
        at = np.stack([(v - row) * line.shape[0] - 0.5, (u + 2 * row) * 28 % line.shape[1] - 0.5])
        return map_coordinates(line, at, order=1, mode="grid-wrap")

    return pattern


def both(one: Ornament, two: Ornament, share: float = 0.5) -> Ornament:
    """Two ornaments added; the second has ``share`` of the height."""

    def heights(s: Surface, rng: Rng) -> Array:
        a, b = one(s, rng), two(s, rng)
        return (1 - share) * a / np.ptp(a) + share * b / np.ptp(b)

    return heights

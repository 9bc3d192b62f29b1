"""Patterns that repeat: studs, grooves, ripples, grain, stones and dimples in space, and flat ones."""

from __future__ import annotations

import numpy as np
from ornament import Flat, Ornament, Rng, waves
from scattered import distances
from scipy.spatial import cKDTree
from surface import Array, Surface, smooth_step
from tessellation import fibonacci

Way = tuple[float, float, float]


def studs(wave: float, way: Way = (0.36, 0.48, 0.8)) -> Ornament:
    """Alternating bumps and hollows in three directions: a product of sines."""

    def heights(s: Surface, rng: Rng) -> Array:
        phase = 2 * np.pi / (wave * s.edge) * (s.vertices @ axes(way).T) + rng.uniform(0, 2 * np.pi, 3)
        return np.sin(phase[:, 0]) * np.sin(phase[:, 1]) + 0.5 * np.sin(phase[:, 2]) * np.sin(phase[:, 0])

    return heights


def axes(way: Way) -> Array:
    """Three perpendicular directions, the first along ``way``."""
    one = np.asarray(way, dtype=float) / np.linalg.norm(way)
    two = np.cross(one, np.eye(3)[np.argmin(np.abs(one))])
    two /= np.linalg.norm(two)
    return np.stack([one, two, np.cross(one, two)])


def grooves(wave: float, way: Way, width: float = 0.35) -> Ornament:
    """Straight grooves side by side, with flat bottoms and flat ridges; ``width`` of a wave is groove."""

    def heights(s: Surface, rng: Rng) -> Array:
        off = np.abs((s.vertices @ axes(way)[0] / (wave * s.edge)) % 1 - 0.5)
        return smooth_step(off, width / 2 - 0.12, width / 2 + 0.12)

    return heights


def ripples(wave: float, centre: Way = (0, 0, 0)) -> Ornament:
    """Rings around a point, like ripples in water."""

    def heights(s: Surface, rng: Rng) -> Array:
        return np.cos(2 * np.pi / (wave * s.edge) * np.linalg.norm(s.vertices - np.array(centre, dtype=float), axis=1))

    return heights


def grain(wave: float, way: Way = (0.1, 1, 0.05), sway: float = 0.5) -> Ornament:
    """Wood: wavy sleeves around an axis beside the form, steeper on one side than on the other."""

    def heights(s: Surface, rng: Rng) -> Array:
        along, one, two = (s.vertices @ axes(way).T).T
        reach = float(np.ptp(one)) / 2
        off = np.hypot(one - 0.7 * reach, two + 0.4 * reach)
        flat = np.stack([0.25 * along, one, two], axis=1)
        phase = (off / (wave * s.edge) + sway * waves(flat, 7 * wave * s.edge, rng, 24)) % 1
        return smooth_step(phase, 0.0, 0.55) * (1 - smooth_step(phase, 0.55, 1.0))

    return heights


def stones(wave: float, joint: float = 0.16) -> Ornament:
    """Stones of many sizes laid side by side, flat, each somewhat higher than the next."""

    def heights(s: Surface, rng: Rng) -> Array:
        away, which, places = distances(s, wave, rng, 2)
        tall = rng.uniform(0.6, 1.0, len(places))[which[:, 0]]
        return smooth_step(away[:, 1] - away[:, 0], 0.02, 2 * joint) * tall

    return heights


def dimples(count: int, size: float = 0.42) -> Ornament:
    """Golf ball dimples over a form around the origin; ``size`` is their width as a fraction of their spacing."""

    def heights(s: Surface, rng: Rng) -> Array:
        way = s.vertices / np.linalg.norm(s.vertices, axis=1, keepdims=True)
        away = cKDTree(fibonacci(count)).query(way)[0] / np.sqrt(4 * np.pi / count)
        return -np.sqrt((1 - (away / size) ** 2).clip(0, None))

    return heights


def wound(pattern: Flat, across: int, along: int) -> Ornament:
    """A flat pattern on a form whose two coordinates go from 0 to 1 and close: numbers of waves around each."""

    def heights(s: Surface, rng: Rng) -> Array:
        assert s.uv is not None
        return pattern(s.uv[:, 0] * across, s.uv[:, 1] * along)

    return heights


def eggs(u: Array, v: Array) -> Array:
    """Alternating bumps and hollows, one of each per two waves."""
    return np.sin(np.pi * u) * np.sin(np.pi * v)


def beads(u: Array, v: Array) -> Array:
    """Round beads in rows, a wave apart, with a thread between the rows."""
    ball = np.sqrt((1 - 4.8 * (((u % 1) - 0.5) ** 2 + ((v % 1) - 0.5) ** 2)).clip(0, None))
    return np.maximum(ball, 0.35 * np.exp(-(((np.minimum(v % 1, 1 - v % 1)) / 0.1) ** 2)))


def honeycomb(u: Array, v: Array) -> Array:
    """Six-sided hollows with walls between them; rows are 0.866 waves apart."""
    best = np.full(u.shape, np.inf)
    for shift in (0.0, 0.5):
        x = (u + shift + 0.5) % 1 - 0.5
        y = ((v * 0.5 + shift + 0.5) % 1 - 0.5) * np.sqrt(3)
        best = np.minimum(best, np.maximum(np.abs(x), np.abs(x) / 2 + np.abs(y) * np.sqrt(3) / 2))
    return smooth_step(best, 0.28, 0.46)


def fish(u: Array, v: Array) -> Array:
    """Round scales in rows; each row is offset by half a scale and overlaps the next."""
    total = np.zeros(u.shape)
    for row in (0, 1, 2):
        base = np.floor(v) - row
        x = (u + base / 2) % 1 - 0.5
        y = v - base
        inside = smooth_step(1.0 - np.hypot(x / 0.56, (y - 0.5) / 1.05), 0.0, 0.25)
        total = np.maximum(total, inside * (0.3 + 0.4 * y))
    return total


def chevrons(u: Array, v: Array) -> Array:
    """Zigzag ridges."""
    return np.abs(np.sin(np.pi * (v + 2 * np.abs((u / 2) % 1 - 0.5))))


def screw(u: Array, v: Array) -> Array:
    """Flutes around the form."""
    return -(np.abs(np.cos(np.pi * (u + 0.5 * v))) ** 1.5)


def ribs(u: Array, v: Array) -> Array:
    """Ridges across, sharp above and round below."""
    return 1 - np.abs(np.sin(np.pi * v))

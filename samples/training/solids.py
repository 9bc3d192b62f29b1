"""Smoothly merged base forms: fields, negative inside, of heads, bodies, animals, vessels and machine parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from soft_solids import Point, ball, carve, join, rod
from surface import Array

Rng = np.random.Generator


def dilated(p: Array, rods: Sequence[tuple[Point, Point, float, float]], soft: float) -> Array:
    """Merged rods."""
    total = rod(p, *rods[0])
    for one in rods[1:]:
        total = join(total, rod(p, *one), soft)
    return total


def mirrored(p: Array) -> Array:
    """Positions of both halves, mirrored to positive x."""
    return np.concatenate([np.abs(p[:, :1]), p[:, 1:]], axis=1)


def blob(rng: Rng, count: int = 7, spread: float = 7.0) -> Callable[[Array], Array]:
    """A heap of merged balls."""
    centres = rng.uniform(-1, 1, (count, 3)) * spread * (1.1, 0.9, 0.6)
    sizes = rng.uniform(4, 7.5, count)

    def field(p: Array) -> Array:
        total = ball(p, (0, 0, 0), 6)
        for centre, size in zip(centres, sizes, strict=True):
            total = join(total, ball(p, centre, float(size)), 4)
        return total

    return field


def head(p: Array) -> Array:
    """A head with brow, nose, lips, chin, eyes and ears on a neck."""
    q = mirrored(p)
    total = join(ball(q, (0, 3, -1), (8, 9, 9.5)), ball(q, (0, -4, 2), (6, 7, 6.5)), 3)
    total = join(total, rod(q, (0, -7, -2), (0, -16, -4), 4.6, 5.4), 2)
    total = join(total, rod(q, (0, 2.2, 7.6), (5.5, 2.0, 5.6), 1.3, 1.0), 1.5)
    total = carve(total, ball(q, (3.2, 0.2, 9.2), (2.2, 1.5, 2.2)), 1.2)
    total = join(total, ball(q, (3.1, 0.1, 6.1), 1.7), 0.5)
    total = join(total, rod(q, (0, 1.0, 8.3), (0, -3.2, 10.0), 0.8, 1.4), 1.2)
    total = join(total, rod(q, (0, -6.0, 7.6), (1.8, -6.1, 6.9), 0.9, 0.5), 0.6)
    total = join(total, ball(q, (0, -9.2, 6.2), 2.0), 1.5)
    ear = carve(ball(q, (8.2, 0, -1.5), (1.3, 3.2, 2.2)), ball(q, (9.5, 0.2, -0.9), (1.2, 2.0, 1.4)), 0.5)
    return carve(join(total, ear, 0.6), p[:, 1] + 13.5, 1.0)


def torso(p: Array) -> Array:
    """Neck, shoulders, chest, waist and hips, cut off where statues are."""
    q = mirrored(p)
    total = join(ball(q, (0, 5, 0), (7.5, 7, 4.6)), ball(q, (0, -9, 0), (7.2, 6, 5)), 4)
    total = join(total, rod(q, (0, -9, 0), (0, 5, 0), 5.0, 5.0), 3)
    total = join(total, rod(q, (3, 9.5, -0.5), (8.5, 8.2, -0.5), 2.4, 2.8), 2)
    total = join(total, rod(q, (8.7, 8, -0.5), (10.2, 1.5, 0.4), 2.5, 2.1), 1)
    total = join(total, rod(q, (0, 10, -0.5), (0, 15.5, 0.4), 2.6, 2.5), 2)
    total = join(total, ball(q, (3.3, 4.6, 3.3), (3.2, 2.9, 2.6)), 1.5)
    total = join(total, rod(q, (3.8, -11, 0), (4.2, -18, 0.5), 4.0, 3.4), 1.5)
    total = carve(total, ball(q, (0, -4.6, 5.6), 0.9), 0.8)
    return carve(total, p[:, 1] + 16.5, 1.0)


def animal(p: Array) -> Array:
    """A beast with four legs, a tail, a neck and a head with ears; it looks to +x."""
    q = np.stack([p[:, 0], p[:, 1], np.abs(p[:, 2])], 1)
    total = join(rod(q, (-8, 0, 0), (6, 1, 0), 4.2, 4.6), rod(q, (6, 2, 0), (11, 8, 0), 3.3, 2.4), 3)
    total = join(total, rod(q, (11, 8.5, 0), (15.5, 6.5, 0), 2.5, 1.3), 1)
    for x, foot in ((-8.5, -10.5), (6.5, 7.0)):
        total = join(total, rod(q, (x, -1, 2.2), (x - 0.7, -7, 2.6), 2.3, 1.3), 1.5)
        total = join(total, rod(q, (x - 0.7, -7, 2.6), (foot, -13, 2.6), 1.3, 1.1), 0.6)
        total = join(total, rod(q, (foot, -13, 2.6), (foot + 1.6, -13.3, 2.6), 1.2, 1.0), 0.6)
    total = join(total, rod(q, (-11, 2, 0), (-16, 5, 0), 1.3, 0.8), 1)
    total = join(total, rod(q, (-16, 5, 0), (-18, 10, 0), 0.9, 0.7), 0.6)
    return join(total, rod(q, (10.3, 10, 1.4), (9.4, 13, 2.3), 1.0, 0.6), 0.6)


def vessels(p: Array) -> Array:
    """A trunk that divides three times into thinner and thinner branches."""
    rods, ends = [((0.0, -16.0, 0.0), (0.5, -7.0, 0.0), 2.8, 2.5)], [((0.5, -7.0, 0.0), 90.0, 2.3, 9.0)]
    for level in range(3):
        following = []
        for start, course, size, length in ends:
            for side in (-1, 1):
                angle = np.radians(course + side * (34 - 4 * level))
                deep = side * (1.5 - 0.4 * level) * (-1) ** level
                end = (start[0] + length * np.cos(angle), start[1] + length * np.sin(angle), start[2] + deep)
                rods.append((start, end, size * 0.85, size * 0.66))
                following.append((end, np.degrees(angle), size * 0.74, length * 0.84))
        ends = following
    return dilated(p, rods, 0.8)


def shell(p: Array) -> Array:
    """An ear: a thin bowl with a rolled rim and a ridge within."""
    bowl = carve(ball(p, (0, 0, 0), (8, 11, 5)), ball(p, (0.4, 0.4, 1.6), (7.2, 10.2, 5.2)), 0.4)
    turn = np.linspace(0, 2 * np.pi, 25)
    rim = np.stack([7.3 * np.cos(turn), 10.3 * np.sin(turn), 0.9 + 0 * turn], 1)
    loop = [(a, b, 0.8, 0.8) for a, b in pairwise(rim)]
    ridge = [((-1.5, -5.5, -2.6), (2.2, -1, -2.7), 0.9, 1.1), ((2.2, -1, -2.7), (1.5, 5.5, -2.2), 1.1, 0.8)]
    return join(join(bowl, dilated(p, loop, 0.2), 0.8), dilated(p, ridge, 0.5), 0.8)


def disk_part(p: Array) -> Array:
    """Part of a fan's disk: cylinders and slanting planes that meet at sharp and at blunt edges."""
    x, y, z = p.T
    sector = np.maximum(np.hypot(x + 12, y) - 22, 8 - np.hypot(x + 12, y))
    sector = np.maximum(sector, np.abs(y) * 0.94 - 0.34 * (x + 12) - 2)
    thick = np.maximum(z - (4 - 0.25 * x), -z - 4)
    part = np.maximum(sector, np.maximum(thick, z - 4.5 - 0.12 * y))
    return np.maximum(part, 3.4 - np.hypot(x - 2, z - 5.5))


def bracket(p: Array) -> Array:
    """Two plates at an angle with a rib between them and a bore through one."""
    x, y, z = p.T
    base = np.maximum.reduce([np.abs(x) - 11, np.abs(y + 7) - 2.2, np.abs(z) - 8])
    wall = np.maximum.reduce([np.abs(x + 8) - 2.6, np.abs(y - 1) - 10, np.abs(z) - 8])
    rib = np.maximum.reduce([np.abs(z) - 2.2, x + y - 4, -x - 8, -y - 7])
    return np.maximum(np.minimum(np.minimum(base, wall), rib), 4 - np.hypot(y - 4.6, z - 0.0) - 0 * x)

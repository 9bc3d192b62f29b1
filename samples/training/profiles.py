"""Outlines, sections and heights of the catalogue's own forms, and the areas with ornament."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from forms import curved, drawn, globe
from surface import Array, Surface, smooth_step
from tessellation import fibonacci, sharpened

STEPS = ((8, 0), (8, 3), (11, 3), (11, 6), (6.5, 8.5), (6.5, 19), (9, 21.5), (9, 24), (5, 26))
VASE = (
    (5.0, 0),
    (6.2, 1.0),
    (4.6, 2.6),
    (5.4, 4.5),
    (9.0, 9),
    (9.6, 14),
    (7.0, 19.5),
    (4.2, 23),
    (4.6, 26),
    (6.0, 27.5),
)
DRUM = ((10, 0), (10, 14), (8.5, 15.5), (8.5, 17))
LETTER_E = (
    (0, 0),
    (12, 0),
    (12, 4),
    (4.5, 4),
    (4.5, 8),
    (10, 8),
    (10, 12),
    (4.5, 12),
    (4.5, 16),
    (12, 16),
    (12, 20),
    (0, 20),
)
RING = [(12 * np.cos(t), 12 * np.sin(t)) for t in np.arange(60) * np.pi / 30]
HORN = ((-10, -6, 0), (-4, -9, 1), (4, -6, 2), (8, 1, 1), (5, 8, 0), (-1, 9, -1), (-3, 4, -1))


def above(level: float, soft: float = 1.0) -> Callable[[Array], Array]:
    """On the upper part only."""
    return lambda p: smooth_step(p[:, 1], level - soft, level + soft)


def trunk(p: Array) -> Array:
    """The chest and belly of the torso, without its arms."""
    return above(-4)(p) * (1 - smooth_step(np.abs(p[:, 0]), 6.0, 7.5)) * (1 - smooth_step(p[:, 1], 9.5, 11.0))


def hide(p: Array) -> Array:
    """The beast's body and neck, without its legs, head and tail."""
    x, y = p[:, 0], p[:, 1]
    return smooth_step(y, -4.5, -3.0) * smooth_step(x, -12.0, -10.5) * (1 - smooth_step(x + 0.6 * y, 14.0, 15.5))


def bowl(p: Array) -> Array:
    """The ear without its rim."""
    return 1 - smooth_step(p[:, 2], -1.2, -0.4)


def band(low: float, high: float, soft: float = 0.6) -> Callable[[Array], Array]:
    """Between two heights only."""
    return lambda p: smooth_step(p[:, 1], low - soft, low + soft) * (1 - smooth_step(p[:, 1], high - soft, high + soft))


def within(radius: float) -> Callable[[Array], Array]:
    """Around the z axis only."""
    return lambda p: 1 - smooth_step(np.hypot(p[:, 0], p[:, 1]), radius - 0.3, radius + 0.3)


def hair(p: Array) -> Array:
    """The scalp of the head."""
    return smooth_step(p[:, 1] - 3.5 - 0.75 * (p[:, 2] + 1).clip(-8, None), -0.6, 0.6)


def medal(p: Array) -> Array:
    """A field that sinks to a bust, within a raised rim."""
    r = np.hypot(*p.T)
    bust = 3.2 * np.exp(-(((p[:, 0] + 0.5) / 4.6) ** 2) - ((p[:, 1] + 0.5) / 5.8) ** 2)
    return bust + 0.9 * smooth_step(r, 9.9, 11.4)


def folds(p: Array) -> Array:
    """Drapery."""
    u, v = p.T
    return 1.8 * np.sin(0.55 * u + 0.6 * np.sin(0.16 * v)) + 0.9 * np.sin(0.23 * u - 0.2 * v)


def pebble(d: Array) -> Array:
    """A smooth stone."""
    return 9 + 1.6 * d[:, 0] ** 2 + 0.8 * d[:, 1] * d[:, 2] - 1.5 * d[:, 1] ** 2


def cut_stone(p: Array) -> Array:
    """Field of a stone cut in a dozen planes."""
    return np.asarray((p @ fibonacci(13).T - 8 - np.cos(7 * np.arange(13))).max(axis=1))


def crystal(directions: Array) -> Surface:
    """The same stone with a vertex in each direction, or on the crease next to it."""
    at_one = 1 / (directions @ fibonacci(13).T / (8 + np.cos(7 * np.arange(13)))).max(axis=1)
    return sharpened(globe(directions, lambda _: at_one), cut_stone, 3)


def mask_face(d: Array) -> Array:
    """An egg with brow, nose, cheeks and chin."""
    x, y, z = np.abs(d[:, 0]), d[:, 1], d[:, 2]
    front = smooth_step(z, 0, 0.6)
    nose = 1.6 * np.exp(-((x / 0.13) ** 2) - ((y + 0.08) / 0.2) ** 2)
    eyes = -1.1 * np.exp(-(((x - 0.33) / 0.17) ** 2) - ((y - 0.12) / 0.11) ** 2)
    lips = 0.6 * np.exp(-((x / 0.22) ** 2) - ((y + 0.45) / 0.08) ** 2)
    chin = 0.8 * np.exp(-((x / 0.25) ** 2) - ((y + 0.75) / 0.15) ** 2)
    return 9 + 1.5 * y * y - 0.8 * x * x + front * (nose + eyes + lips + chin)


def horn(count: int, cols: int) -> Surface:
    """A curved horn that ends in a point."""
    line = curved(HORN, count)
    return drawn(line, np.linspace(3.4, 0.9, count), cols)


def clear_of_tips(p: Array) -> Array:
    """The horn without its ends."""
    near = np.minimum(*(np.linalg.norm(p - np.array(end, dtype=float), axis=1) for end in (HORN[0], HORN[-1])))
    return smooth_step(near, 3.0, 6.0)

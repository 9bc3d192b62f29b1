"""The held-out meshes; parameters found by `choose_parameters`."""

from __future__ import annotations

import numpy as np
from entry import KEPT, Entry
from form_makers import extruded, solid, spun
from forms import cloth, curved, drawn, gear, globe, polygon, sheet, uneven
from ornament import both, bricks, chased, fractal, knurl, laid, noise, tiles, waves, writing
from profiles import above, crystal, hair
from scattered import bosses, cells, fur, pores, scales
from solids import animal, bracket, head, torso
from surface import Array, Surface
from tessellation import fibonacci

GOBLET = ((7, 0), (7, 1.2), (1.8, 3.5), (1.6, 9), (2.4, 10), (7.5, 14), (8.2, 20), (7.6, 20.8))
CROSS = np.array(
    [(4, -10), (4, -4), (10, -4), (10, 4), (4, 4), (4, 10), (-4, 10), (-4, 4), (-10, 4), (-10, -4), (-4, -4), (-4, -10)]
)
SPIRAL = [((1.2 + 0.9 * t) * np.cos(t), (1.2 + 0.9 * t) * np.sin(t), 0.5 * t) for t in np.linspace(0.4, 10.5, 24)]
SQUARE = np.array([(-11, -9), (11, -9), (11, 9), (-11, 9)])


def roof(p: Array) -> Array:
    """Two slopes and a dormer that meet in ridges and valleys."""
    return np.maximum(7 - 0.75 * np.abs(p[:, 1]), 5.2 - 0.95 * np.abs(p[:, 0] - 3) - 1e3 * (p[:, 1] > 0))


def dome(d: Array) -> Array:
    return 9 / (np.abs(d) ** 4).sum(axis=1) ** 0.25


def snail() -> Surface:
    """A tube that winds outward and widens."""
    return drawn(curved(SPIRAL, 260), np.linspace(0.7, 4.0, 260), 30)


HELD_OUT = (
    Entry("bracket pores", "creased", solid(bracket, 0.5, creased=True), (2, 0.2, 4), pores(5), 0.5),
    Entry(
        "cross scales", "creased", extruded(CROSS, 5, 0.52, diagonal="one"), (8, 0.3, 4), scales(6, (0.5, -1, 0.3)), 0.7
    ),
    Entry("goblet bricks", "creased", spun(GOBLET, 84, 0.42, "other"), (2, 0.3, 6), laid(bricks, 5), 0.9, above(13.5)),
    Entry("gear fractal", "creased", extruded(gear(9, 11, 8), 5, 0.44), (8, 0.2, 8), fractal(9, 3), 0.4, noise=0.05),
    Entry(
        "roof tiled",
        "creased",
        lambda rng: cloth((22, 18), (110, 70), lambda p: roof(p - (11, 9))),
        (3, 0.2, 4),
        laid(tiles, 5),
        0.6,
    ),
    Entry("head cells", "organic", solid(head, 0.44), (2, 0.4, 4), cells(7), 0.7, hair),
    Entry("beast bosses", "organic", solid(animal, 0.44), (2, 0.7, 4), bosses(5), 0.7),
    Entry("torso knitted", "organic", solid(torso, 0.44), (3, 0.4, 4), both(chased(6), noise(4), 0.3), 0.6, above(-12)),
    Entry("snail fur", "organic", lambda rng: snail(), (2, 0.7, 4), fur(3, 5, (1, 0.4, 0)), 0.5),
    Entry(
        "dome crackled",
        "ornament",
        lambda rng: globe(uneven(6000, 6), dome),
        (12, 0.4, 4),
        lambda s, rng: np.abs(waves(s.vertices, 8 * s.edge, rng)) ** 0.5,
        0.7,
    ),
    Entry(
        "tablet letters",
        "ornament",
        lambda rng: sheet(SQUARE, 0.3, lambda p: 1.5 * np.cos(0.12 * p[:, 0]) + 0.6 * np.sin(0.3 * p[:, 1]), rng),
        (5, 0.2, 4),
        laid(writing("ROMASONATNOVA"), 9, 1.4),
        0.9,
    ),
    Entry("crystal", "plain", lambda rng: crystal(fibonacci(4000)), KEPT),
    Entry(
        "small column knurled",
        "creased",
        extruded(polygon(8, 6), 16, 0.6),
        (2, 0.2, 5),
        laid(knurl, 5),
        0.7,
        lambda p: (np.abs(p[:, 2] - 8) < 7.7) * 1.0,
        rim=(0.5, 1.5),
        finer=(4, 0.2, 5),
    ),
)

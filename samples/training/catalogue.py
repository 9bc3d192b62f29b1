"""The training meshes; parameters found by `choose_parameters`."""

from __future__ import annotations

import numpy as np
from entry import KEPT, Entry
from form_makers import block, extruded, folded, lump, solid, spun
from forms import curved, drawn, gear, globe, knot, polygon, sheet, star, uneven
from ornament import (
    both,
    bricks,
    chased,
    flutes,
    fractal,
    hammered,
    knurl,
    laid,
    locks,
    noise,
    rings,
    rope,
    weave,
    writing,
)
from profiles import (
    DRUM,
    LETTER_E,
    RING,
    STEPS,
    VASE,
    above,
    band,
    bowl,
    clear_of_tips,
    crystal,
    hair,
    hide,
    horn,
    mask_face,
    medal,
    pebble,
    trunk,
    within,
)
from scattered import bosses, cells, fur, pores, scales
from solids import animal, disk_part, head, shell, torso, vessels
from tessellation import fibonacci, irregular

TRAINING = (
    # creases and ornament
    Entry("box noise", "creased", block((20, 14, 9), 0.68), (12, 0.2, 4), noise(5), 0.45),
    Entry(
        "box bricks",
        "creased",
        block((16, 20, 10), 0.62, diagonal="one"),
        (10, 0.4, 5),
        laid(bricks, 5),
        0.8,
        rim=(0.6, 1.4),
    ),
    Entry("rounded box pores", "creased", block((18, 13, 10), 0.62, 1.6), (5, 0.4, 4), pores(6), 0.7),
    Entry("steps knurled", "creased", spun(STEPS, 84, 0.68), (2, 0.4, 8), laid(knurl, 8), 0.7, rim=(0.5, 1.5)),
    Entry("star hammered", "creased", extruded(star(5, 12, 5.5), 6, 0.55), (10, 0.4, 6), hammered(7), 0.5),
    Entry(
        "hexagon woven",
        "creased",
        extruded(polygon(6, 10), 9, 0.58, diagonal="other"),
        (4, 0.3, 8),
        laid(weave, 5),
        0.9,
        rim=(0.5, 1.5),
    ),
    Entry("letter fractal", "creased", extruded(np.array(LETTER_E), 4.5, 0.5), (10, 0.2, 4), fractal(12), 0.4),
    Entry("disk part pores", "creased", solid(disk_part, 0.42, creased=True), (3, 0.2, 5), pores(6), 0.6, noise=0.05),
    Entry("drum cells", "creased", spun(DRUM, 100, 0.6), (5, 0.4, 8), cells(7), 0.8),
    Entry("crystal chased", "creased", lambda rng: crystal(irregular(4500, rng)), (4, 0.2, 5), chased(5), 0.45),
    Entry(
        "slanted star fur",
        "creased",
        extruded(star(4, 12, 8), 5, 0.5, lambda p: 0.28 * p[:, 0] + 2.5),
        (10, 0.3, 5),
        fur(3, 4, (0.6, -1, 0.3)),
        0.5,
    ),
    Entry(
        "small box bosses",
        "creased",
        block((14, 14, 14), 0.7),
        (3, 0.3, 4),
        bosses(7),
        0.8,
        rim=(0.5, 1.5),
        finer=(6, 0.3, 4),
    ),
    # organic forms
    Entry("blob scales", "organic", lump((20, 18, 15), 0.6), (3, 0.5, 4), scales(7), 0.8),
    Entry("head locks", "organic", solid(head, 0.53), (1.5, 0.2, 4), locks((0, 0.6, -1), 34, 0.05), 0.9, hair),
    Entry("torso fur", "organic", solid(torso, 0.56), (2, 0.4, 4), fur(3), 0.6, trunk),
    Entry(
        "vessels bark",
        "organic",
        solid(vessels, 0.46),
        (1.5, 0.7, 4),
        fur(2.5, 6, (0, 1, 0)),
        0.6,
        lambda p: 1 - above(0)(p),
    ),
    Entry("beast fur", "organic", solid(animal, 0.53), (1.5, 0.7, 4), fur(3, 5, (-1, -0.6, 0)), 0.6, hide),
    Entry("ear cells", "organic", solid(shell, 0.54), (2, 0.2, 4), cells(5), 0.5, bowl, noise=0.05),
    Entry("mask pores", "organic", lambda rng: globe(uneven(4600), mask_face), (2, 0.3, 4), pores(5), 0.5),
    Entry("small blob bumps", "organic", lump((18, 16, 14), 0.95, 5, 6), (3, 0.7, 4), noise(5), 0.5, finer=(6, 0.7, 4)),
    # much ornament
    Entry("vase chased", "ornament", spun(curved(VASE, 100), 48, 0.3), (2, 0.5, 5), chased(5), 0.6, band(6, 24)),
    Entry(
        "vase fluted",
        "ornament",
        spun(curved(VASE, 76), 66, 0.45, "one"),
        (2, 0.7, 5),
        laid(flutes, 7),
        0.9,
        band(7, 24),
    ),
    Entry(
        "knot rope",
        "ornament",
        lambda rng: drawn(knot(2, 3, 200), np.full(200, 2.6), 26, True),
        (3, 0.7, 8),
        laid(rope, 5),
        0.7,
    ),
    Entry(
        "ball bosses",
        "ornament",
        lambda rng: globe(fibonacci(4800), lambda d: 10 + 0 * d[:, 0]),
        (3, 0.3, 4),
        bosses(8),
        1.0,
    ),
    Entry(
        "pebble fractal",
        "ornament",
        lambda rng: globe(irregular(4200, rng), pebble),
        (6, 0.7, 4),
        fractal(14, 4, 0.55),
        0.6,
    ),
    Entry(
        "medal letters",
        "ornament",
        lambda rng: sheet(np.array(RING), 0.31, medal, rng),
        (2, 0.7, 4),
        laid(writing("SALVETOMNES"), 10, 1.4),
        1.0,
        within(9.2),
    ),
    Entry("cloth woven", "ornament", folded((72, 72)), (3, 0.4, 4), laid(weave, 4), 0.8, noise=0.05),
    Entry("cloth cells long", "ornament", folded((120, 40), "other"), (3, 0.5, 4), both(cells(9), noise(4), 0.3), 0.7),
    Entry("horn rings", "ornament", lambda rng: horn(150, 32), (3, 0.2, 4), laid(rings, 6), 0.6, clear_of_tips),
    # without ornament
    Entry("gear", "plain", extruded(gear(12, 11, 8.6), 4, 0.5), KEPT),
    Entry("steps", "plain", spun(STEPS, 70, 0.85, "one"), KEPT),
    Entry("vessels", "plain", solid(vessels, 0.55), KEPT),
    Entry("torso", "plain", solid(torso, 0.7, 1), KEPT),
)

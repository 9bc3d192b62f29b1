"""More training meshes: simple forms with many patterns of many sizes; parameters found by a coarse search."""

from __future__ import annotations

import numpy as np
from entry import KEPT, Entry
from form_makers import block, extruded, lump, spun
from forms import gear, polygon
from ornament import bricks, fractal, hammered, knurl, laid, noise, weave, writing
from regular import (
    beads,
    chevrons,
    dimples,
    eggs,
    fish,
    grain,
    grooves,
    honeycomb,
    ribs,
    ripples,
    screw,
    stones,
    studs,
    wound,
)
from scattered import bosses, cells, fur, pores
from simple_forms import (
    ANGLE,
    CIRCLE,
    EIGHT,
    PYRAMID,
    SPOOL,
    TRIANGLE,
    bars,
    bent,
    capsule,
    carved,
    coil,
    cut,
    dish,
    egg,
    oval,
    torus,
    ziggurat,
)
from tessellation import fibonacci

FACETS = fibonacci(70), 8.5 + 0.5 * np.cos(5 * np.arange(70))

MORE = (
    # repeating patterns on round forms, from fine to broad
    Entry("ball studs fine", "ornament", oval(2050, (10, 10, 10)), (4, 0.4, 4), studs(2.8), 0.5),
    Entry("egg studs", "ornament", egg(2050), (6, 0.4, 6), studs(4), 0.7),
    Entry("lens studs", "ornament", oval(2350, (13, 6, 11), "even"), (4, 0.5, 4), studs(6), 0.45, noise=0.05),
    Entry("cushion studs broad", "ornament", oval(2350, (11, 7, 9), "uneven", 4), (8, 0.4, 4), studs(10), 0.4),
    Entry("golf ball", "ornament", oval(2150, (10, 10, 10), "even"), (6, 0.5, 4), dimples(90), 0.5),
    Entry("tyre knurled", "ornament", torus(100, 24, 9, (2.4, 3.4, 4)), (2, 0.4, 4), wound(knurl, 8, 32), 0.7),
    Entry("ring honeycomb", "ornament", torus(84, 26), (3, 0.35, 4), wound(honeycomb, 5, 20), 0.8),
    Entry("ring ribs", "ornament", torus(126, 18, 10, (2, 2, 2), "one"), (1.5, 0.2, 6), wound(ribs, 1, 42), 1.0),
    Entry("ring screw", "ornament", torus(88, 26, 9, (3.6, 3.6, 2)), (2, 0.35, 6), wound(screw, 8, 16), 0.6),
    Entry("capsule fish", "ornament", capsule(44, 0.65, 5.5, 14), (2, 0.4, 4), laid(fish, 6), 0.6),
    Entry("capsule beads", "ornament", capsule(40, 0.75, 5, 18, "one"), (2, 0.7, 4), laid(beads, 5), 1.2),
    Entry("ball stones", "ornament", oval(2300, (9, 11, 10), "uneven"), (8, 0.7, 4), stones(7), 0.7),
    Entry("egg grain", "organic", egg(2150), (3, 0.7, 4), grain(5), 0.5),
    Entry("lens ripples", "ornament", oval(2150, (11, 7.5, 10)), (4, 0.7, 4), ripples(4, (3, 4, 1)), 0.5),
    # sheets
    Entry("dish ripples", "ornament", dish(CIRCLE, 0.4, 2), (12, 0.2, 4), ripples(7, (2, -1, 0)), 0.6),
    Entry("sheet grain", "ornament", bent((26, 20), (58, 44), 0.5), (2, 0.2, 4), grain(5, (1, 0.1, 0)), 0.4),
    Entry("sheet honeycomb", "ornament", bent((22, 20), (56, 48), 0.6, "one"), (4, 0.7, 4), laid(honeycomb, 9), 0.7),
    Entry(
        "sheet chevrons long", "ornament", bent((24, 22), (86, 28), 1.2, "other"), (1.5, 0.4, 4), laid(chevrons, 4), 0.3
    ),
    Entry("sheet eggs faint", "ornament", bent((22, 22), (48, 48), 0.4), (8, 0.7, 4), laid(eggs, 2.5), 0.15),
    Entry("sheet waves broad", "ornament", dish(CIRCLE, 0.41, 1.2), (8, 0.2, 6), noise(18), 0.35),
    # combed and rough
    Entry("lens fur fine", "organic", oval(2200, (9, 6, 12)), (3, 0.5, 4), fur(2, 5, (0.3, 0.2, 1)), 0.45),
    Entry("egg fur", "organic", egg(2200), (4, 0.5, 4), fur(4, 4), 0.7),
    Entry("ball fractal", "organic", oval(2050, (10, 8, 10), "even"), (8, 0.7, 4), fractal(6, 2), 0.35, noise=0.1),
    Entry(
        "heap cells", "organic", lump((17, 15, 13), 0.82, 4, 5, rounds=1), (3, 0.4, 4), cells(6, 0.25), 0.6, noise=0.08
    ),
    # creases
    Entry(
        "brick grooves",
        "creased",
        block((18, 9, 12), 0.64, diagonal="one"),
        (8, 0.5, 6),
        grooves(6, (1, 0.3, 0.6)),
        1.1,
    ),
    Entry("cube noise", "creased", block((15, 15, 15), 0.76), (12, 0.2, 4), noise(7), 0.35),
    Entry(
        "plate honeycomb", "creased", block((22, 20, 3), 0.71), (3, 0.35, 6), laid(honeycomb, 7), 0.6, rim=(0.5, 1.5)
    ),
    Entry("wedge noise fine", "creased", extruded(TRIANGLE, 9, 0.58), (12, 0.35, 4), noise(2.5), 0.5),
    Entry("angle hammered", "creased", extruded(ANGLE, 8, 0.58), (12, 0.35, 4), hammered(5), 0.6),
    Entry(
        "angle woven",
        "creased",
        extruded(ANGLE, 5, 0.52, diagonal="one"),
        (6, 0.35, 6),
        laid(weave, 4),
        0.6,
        noise=0.08,
    ),
    Entry(
        "coin letters",
        "creased",
        extruded(CIRCLE, 2.5, 0.65),
        (12, 0.5, 4),
        laid(writing("VERONA"), 9, 1.3),
        0.9,
        rim=(1, 2),
    ),
    Entry("pyramid stones", "creased", cut(2050, PYRAMID, np.array([5, 5.5, 5, 5, 4.5])), (12, 0.2, 4), stones(6), 0.6),
    Entry("octahedron pores", "creased", cut(2300, EIGHT, np.full(8, 7.0), 5), (12, 0.35, 6), pores(9), 0.5),
    Entry("bars fur", "creased", carved(bars, (9.5, 9.5, 9.5), 0.76), (12, 0.5, 4), fur(2.5, 6, (1, 0.7, 0.4)), 0.5),
    Entry("ziggurat bosses", "creased", carved(ziggurat, (13, 8, 13), 0.8), (8, 0.2, 4), bosses(5), 0.5),
    Entry("spool bricks", "creased", spun(SPOOL, 56, 0.72, "one"), (2, 0.2, 6), laid(bricks, 4), 0.6),
    Entry("cog ripples", "creased", extruded(gear(7, 11, 8), 4, 0.66), (4, 0.2, 4), ripples(5, (0, 0, 2)), 0.2),
    Entry("post grain", "creased", extruded(polygon(5, 5), 18, 0.54), (12, 0.4, 4), grain(4, (0.05, 0.1, 1)), 0.4),
    # coarse, and the same with one subdivision
    Entry("small ball studs", "ornament", oval(800, (10, 9, 8)), (4, 0.7, 4), studs(5), 0.7, finer=(8, 0.7, 4)),
    Entry(
        "small wedge grooves",
        "creased",
        extruded(TRIANGLE, 8, 0.95),
        (12, 0.35, 6),
        grooves(5, (0.2, 0.1, 1)),
        0.6,
        finer=(12, 0.35, 6),
    ),
    Entry(
        "small box honeycomb",
        "creased",
        block((14, 12, 8), 0.9),
        (6, 0.4, 4),
        laid(honeycomb, 7),
        0.6,
        rim=(0.5, 1.5),
        finer=(12, 0.4, 4),
    ),
    # without ornament
    Entry("capsule", "plain", capsule(36, 0.9), KEPT),
    Entry("stone of many facets", "plain", cut(1800, *FACETS), KEPT),
    Entry("coarse cog", "plain", extruded(gear(26, 12, 10.4), 3, 0.75), KEPT),
    Entry("thin coil", "plain", coil(210, 9, 0.7, 4, 9, 4), KEPT),
    Entry("bent sheet", "plain", bent((26, 16), (60, 30), 2.2), KEPT),
    Entry("bars", "plain", carved(bars, (9.5, 9.5, 9.5), 0.9), KEPT),
    Entry("cushion", "plain", oval(1550, (10, 6, 8), "uneven", 6), KEPT),
)

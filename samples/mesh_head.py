"""The solids of the portrait head, each a field in mm that is negative inside, and how they blend."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mesh_parts import Array
from soft_solids import Point, ball, carve, join, rod

EYE = np.array([8.0, 1.2, 16.0])
BUN = np.array([0.0, -1.0, -32.0])
HAIR_CENTRE = np.array([0.0, 10.0, -5.0])
# the centre line of the roll of hair, from above the forehead over the ear to the bun
ROLL = np.array(
    [
        *((0, 25.6, 13.5), (7, 24.4, 13), (13, 20, 11), (17.5, 13, 7.5), (19.5, 6, 2)),
        *((19, 1, -5), (16, -2.5, -13), (10, -3, -21), (4, -2, -28)),
    ],
    dtype=float,
)
HAIRLINE = np.array([(-30, -17), (-20, -13), (-9, -6), (-5, -1), (2, 6), (12, 12), (20, 16), (30, 18)], dtype=float)


def rods(p: Array, points: Sequence[Point] | Array, radii: Sequence[float]) -> Array:
    """Rods between successive points."""
    made = [rod(p, *points[k : k + 2], *radii[k : k + 2]) for k in range(len(points) - 1)]
    return np.minimum.reduce(made)


def skull(p: Array) -> Array:
    """The large forms of cranium, face, jaw and neck."""
    f = ball(p, (0, 10, -4), (19.5, 20.5, 25.5))
    f = join(f, ball(p, (0, -5, 5.5), (15.2, 24, 17)), 7)
    f = join(f, rod(p, (13, -13, 1), (3.5, -26.5, 16.5), 4.6, 4.6), 7)
    f = join(f, ball(p, (0, -26.6, 19.0), (5.2, 4.6, 4.6)), 4)
    f = join(f, ball(p, (10.8, -6, 13.5), (5, 4.2, 5.5)), 6)
    f = join(f, ball(p, (8.6, -14.5, 11.5), (5.6, 7, 7)), 6)
    neck = rod(p, (0, -14, -6), (0, -50, -10), 11.5, 13)
    neck = join(neck, rod(p, (14, -10, -8), (2.5, -48, 4), 3.2, 3.0), 5)
    neck = join(neck, rod(p, (6, -42, -10), (15, -52, -9), 8, 8), 9)
    return join(f, neck, 6)


def brow_and_eyes(p: Array) -> Array:
    """The skull with brow, sockets, eyeballs and lids."""
    f = join(skull(p), rods(p, [(1.5, 5.0, 20.6), (7, 6.6, 19.6), (12.5, 5.2, 14.5)], (2.0, 2.0, 1.6)), 4)
    f = carve(f, ball(p, (7.8, 1.0, 22.8), (5.6, 3.8, 5.0)), 3)
    q = p - EYE
    f = join(f, ball(q, (0, 0, 0), 4.8), 0.4)
    ahead = 0.98 * q[:, 2] + 0.17 * q[:, 0] - 3.1  # from the line through the corners of the eye
    opening = np.maximum((q[:, 1] - 1.35 * ahead) / 1.68, (-q[:, 1] - 0.95 * ahead) / 1.38)
    return join(f, carve(ball(q, (0, 0, 0), 5.65), opening, 0.2), 0.4)


def nose(p: Array) -> Array:
    f = rods(p, [(0, 5.5, 21.0), (0, -1, 23.2), (0, -8.6, 27.3)], (1.9, 1.7, 2.2))
    f = join(f, ball(p, (0, -6.0, 21.5), (4.3, 7.0, 4.6)), 2.5)
    f = join(f, ball(p, (2.8, -10.2, 23.6), (1.9, 1.9, 2.9)), 2)
    f = join(f, rod(p, (0, -10.8, 26.8), (0, -12.2, 22.5), 1.4, 1.5), 1.5)
    return carve(f, ball(p, (1.6, -12.2, 25.0), (0.9, 1.0, 1.5)), 0.8)


def mouth(p: Array) -> Array:
    f = ball(p, (0, -18.5, 16.5), (9.5, 7.8, 7.6))
    upper = rods(p, [(0, -17.3, 24.6), (1.8, -16.9, 24.4), (6.6, -18.7, 20.8)], (1.35, 1.45, 0.6))
    lower = rods(p, [(0, -20.9, 23.7), (2.6, -20.7, 23.3), (6.2, -19.0, 20.9)], (1.7, 1.6, 0.6))
    f = join(join(f, upper, 1.2), lower, 1.4)
    line = rods(p, [(0, -19.1, 26.0), (3, -18.9, 25.0), (7.4, -19.0, 21.4)], (0.6, 0.6, 0.5))
    f = carve(f, line, 1.0)
    return carve(f, rod(p, (0, -13, 26.2), (0, -15.6, 26.4), 0.9, 1.1), 1.2)


def ear(p: Array) -> Array:
    """A bowl with a rolled rim and a lobe, tilted back and outwards."""
    f = ball(p, (18.0, -4, -3), (2.4, 8.2, 5.4))
    rim = [(17.6, -3.5, 1.6), (19.6, 1.5, 0.8), (20.6, 4, -3.5), (20.6, 1.5, -7.6), (19.8, -5, -7.0), (18.4, -10, -2.6)]
    f = join(f, rods(p, rim, (1.0, 1.2, 1.3, 1.3, 1.2, 1.8)), 1.2)
    f = carve(f, ball(p, (21, -4.2, -2.2), (2.6, 4.0, 2.6)), 1.0)
    return join(f, ball(p, (17.6, -5.5, 1.4), (1.6, 1.8, 1.2)), 1.0)


def hair_parts(points: Array) -> dict[str, Array]:
    """Fields of the parts that the hair treats separately."""
    p = np.concatenate([np.abs(points[:, :1]), points[:, 1:]], axis=1)
    face = join(join(brow_and_eyes(p), nose(p), 2.2), mouth(p), 3.5)
    cap = ball(p, HAIR_CENTRE, (21.4, 21.6, 26.4))
    cap = carve(cap, np.interp(p[:, 1], *HAIRLINE.T) - p[:, 2], 2)
    roll = rods(p, ROLL, (3.6, 4.2, 4.6, 4.8, 4.8, 4.8, 4.8, 4.6, 4.2))
    bun = ball(p, BUN, (8.6, 8.6, 7.4))
    return {"face": face, "ear": ear(p), "cap": cap, "roll": roll, "bun": bun}


def head(points: Array) -> Array:
    """The field of the whole head, cut level below the neck."""
    part = hair_parts(points)
    f = join(part["face"], part["ear"], 1.5)
    f = join(f, part["cap"], 1.0)
    f = join(f, join(part["roll"], part["bun"], 2.0), 1.8)
    return carve(f, points[:, 1] + 42.5 - 0.012 * (points[:, 0] ** 2), 2.5)

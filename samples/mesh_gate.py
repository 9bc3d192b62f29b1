"""A town gate between two round towers: flat walls, an arch, battlements, conical roofs; each part is a closed body."""

from __future__ import annotations

import numpy as np
from mesh_parts import Array, Faces, Mesh

SIDES = 24  # of a round tower
_BOX = np.array(
    [
        (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
        (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7),
    ],
    np.int32,
)  # fmt: skip


Corners = list[tuple[float, float]]


def prism(outline: Corners, back: float, front: float, face: Corners | None = None) -> Mesh:
    """Four corners in the plane of the picture, counter-clockwise, and those of the front face if they differ."""
    low = [(x, y, back) for x, y in outline]
    high = [(x, y, front) for x, y in face or outline]
    return np.array(low + high, float), _BOX


def beveled(outline: Corners, back: float, front: float, bevel: float = 0.6) -> Mesh:
    """The same with slanted sides: a normal map shows no step, only what leads up to it."""
    middle = np.mean(outline, axis=0)
    away = [np.array(corner) - middle for corner in outline]
    face = [tuple(middle + each - np.sign(each) * np.minimum(bevel, np.abs(each) / 2)) for each in away]
    return prism(outline, back, front, face)


def rectangle(x: tuple[float, float], y: tuple[float, float]) -> Corners:
    """Its corners between two x and two y."""
    return [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]


def turned(profile: list[tuple[float, float]], x: float, z: float) -> Mesh:
    """A body of revolution about an upright axis; (radius, height) from the bottom to the top, both closed."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = [np.stack([x + r * np.sin(angle), np.full(SIDES, y), z + r * np.cos(angle)], 1) for r, y in profile]
    ends = np.array([(x, profile[0][1], z), (x, profile[-1][1], z)])
    vertices = np.concatenate([*rings, ends])
    here, beside = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    faces = [np.stack([np.full(SIDES, len(vertices) - 2), beside, here], 1)]
    for row in range(len(profile) - 1):
        a, b, c, d = (start + row * SIDES for start in (here, beside, beside + SIDES, here + SIDES))
        faces += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    top = (len(profile) - 1) * SIDES
    faces.append(np.stack([np.full(SIDES, len(vertices) - 1), top + here, top + beside], 1))
    return vertices, np.concatenate(faces).astype(np.int32)


def arch() -> list[Mesh]:
    """The wall around an arch with slanted jambs, a ring of voussoirs, and a door of planks."""
    half, spring, top, steps = 8.0, 18.0, 44.0, 11  # mm; odd, so that no joint lies in the middle
    splay = 2.5
    parts = []
    for side in (-1, 1):
        inner, outer = sorted((side * half, side * 26)), sorted((side * (half + splay), side * 26))
        parts.append(prism(rectangle(inner, (0, spring)), -3, 0, rectangle(outer, (0, spring))))
        parts.append(prism(rectangle(sorted((side * (half + splay), side * 26)), (spring, top)), -3, 0))
    angle = np.linspace(np.pi, 0, steps + 1)
    ring = np.stack([np.cos(angle), np.sin(angle)], 1)
    for i in range(steps):
        behind, ahead = half * ring[i : i + 2] + (0, spring), (half + splay) * ring[i : i + 2] + (0, spring)
        parts.append(
            prism(
                [tuple(behind[0]), tuple(behind[1]), (ahead[1][0], top), (ahead[0][0], top)],
                -3,
                0,
                [tuple(ahead[0]), tuple(ahead[1]), (ahead[1][0], top), (ahead[0][0], top)],
            )
        )
        low, high = (half + splay + 0.3) * ring[i : i + 2], (half + splay + 3.6) * ring[i : i + 2]
        stone = [(cx, cy + spring) for cx, cy in (low[0], low[1], high[1], high[0])]
        parts.append(beveled(stone, -0.5, 0.9))
    parts.append(prism(rectangle((-half - 3, half + 3), (0, spring + half + 3)), -6, -3.2))
    parts += [beveled(rectangle((x, x + 2.6), (0.2, spring + half)), -3.5, -2.6) for x in np.linspace(-8.0, 5.4, 6)]
    return parts


def wall() -> list[Mesh]:
    """The wall with battlements, a string course and two windows with frames."""
    parts = arch()
    parts.append(beveled(rectangle((-26, 26), (34, 36.4)), -0.5, 1.2))
    parts += [prism(rectangle((x, x + 2.9), (44, 47.6)), -6, 0) for x in -25.3 + 5.3 * np.arange(10)]
    for x in (-18.5, 18.5):
        parts.append(beveled(rectangle((x - 3.2, x + 3.2), (12.6, 14.6)), -0.5, 1.4))
        parts.append(beveled(rectangle((x - 3.0, x + 3.0), (23.4, 25.6)), -0.5, 1.2))
        parts += [beveled(rectangle((x + d - 0.9, x + d + 0.9), (14.6, 23.4)), -0.5, 1.0) for d in (-2.1, 2.1)]
    return parts


def tower(x: float) -> list[Mesh]:
    """A round tower with a plinth, a gallery with battlements and a conical roof."""
    parts = [
        turned([(9.0, 0), (8.2, 3), (8.2, 50), (9.6, 53), (9.6, 56)], x, -4),
        turned([(7.4, 56), (7.4, 62)], x, -4),
        turned([(9.0, 62), (8.6, 63), (0.4, 84)], x, -4),
        turned([(8.7, 30), (8.7, 31.4)], x, -4),
    ]
    for turn in np.linspace(-1.2, 1.2, 5):  # merlons on the half that is seen
        cx, cz = x + 8.7 * np.sin(turn), -4 + 8.7 * np.cos(turn)
        parts.append(beveled(rectangle((cx - 1.3, cx + 1.3), (56, 59.4)), cz - 1, cz + 0.9, 0.4))
    parts.append(beveled(rectangle((x - 1.2, x + 1.2), (38, 45)), 2, 4.9))
    return parts


def gate() -> Mesh:
    parts: list[tuple[Array, Faces]] = [*wall(), *tower(-33), *tower(33)]
    firsts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [each + first for (_, each), first in zip(parts, firsts, strict=False)]
    return np.vstack([vertices for vertices, _ in parts]), np.vstack(faces).astype(np.int32)

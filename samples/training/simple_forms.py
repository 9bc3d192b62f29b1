"""Simple forms, each a function of the random numbers for its irregular tessellation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from forms import cloth, curved, drawn, globe, sheet, turned, uneven
from surface import Array, Surface
from tessellation import Bounds, cubes, fibonacci, grid, irregular, outward, sharpened

Form = Callable[[np.random.Generator], Surface]

TRIANGLE = np.array([(-9, -6), (9, -6), (-3, 9)])
ANGLE = np.array([(0, 0), (16, 0), (16, 5), (5, 5), (5, 14), (0, 14)])
CIRCLE = np.array([(10 * np.cos(t), 10 * np.sin(t)) for t in np.arange(64) * np.pi / 32])
STEPPED = ((10, 0), (10, 4), (7.5, 4), (7.5, 9), (5, 9), (5, 15))
SPOOL = ((9, 0), (9, 3), (5, 6), (5, 14), (9, 17), (9, 20))


def oval(count: int, radii: Bounds, cut: str = "irregular", power: float = 2.0) -> Form:
    """An ellipsoid, or with a higher power a boxier form, with irregular, even or uneven triangles."""

    def form(rng: np.random.Generator) -> Surface:
        way = {
            "irregular": lambda: irregular(count, rng),
            "even": lambda: fibonacci(count),
            "uneven": lambda: uneven(count),
        }
        return globe(way[cut](), lambda d: 1 / (np.abs(d / radii) ** power).sum(axis=1) ** (1 / power))

    return form


def egg(count: int, size: float = 9.0) -> Form:
    return lambda rng: globe(irregular(count, rng), lambda d: size * (1 + 0.2 * d[:, 1] ** 2 - 0.12 * d[:, 1]))


def torus(rows: int, cols: int, wide: float = 9.0, tube: Bounds = (3.0, 3.0, 2.0), diagonal: str = "both") -> Form:
    """A ring whose tube has two radii and a power; its coordinates go from 0 to 1."""
    u, v = np.meshgrid(np.arange(cols) / cols, np.arange(rows) / rows)
    a, b = 2 * np.pi * u.ravel(), 2 * np.pi * v.ravel()
    size = (np.abs(np.cos(a) / tube[0]) ** tube[2] + np.abs(np.sin(a) / tube[1]) ** tube[2]) ** (-1 / tube[2])
    off = wide + size * np.cos(a)
    points = np.stack([off * np.cos(b), size * np.sin(a), off * np.sin(b)], 1)
    faces = grid(rows, cols, diagonal, ring=True, closed=True)
    made = outward(Surface(points, faces, np.stack([u.ravel(), v.ravel()], 1)))
    return lambda rng: made


def capsule(cols: int, spacing: float, radius: float = 5.0, length: float = 16.0, diagonal: str = "both") -> Form:
    """A tube with round ends."""
    turn = np.linspace(0.2, np.pi / 2, 12)
    end = np.stack([radius * np.sin(turn), -length / 2 - radius * np.cos(turn)], 1)
    section = np.vstack([end, end[::-1] * (1, -1)])
    return lambda rng: turned(section.tolist(), cols, spacing, rng, diagonal)


def coil(count: int, cols: int, tube: float, winds: float = 2.5, wide: float = 8.0, rise: float = 9.0) -> Form:
    """A tube that winds upward."""
    turn = np.linspace(0, winds * 2 * np.pi, 60)
    line = np.stack([wide * np.cos(turn), rise * turn / (2 * np.pi), wide * np.sin(turn)], 1)
    return lambda rng: drawn(curved(line.tolist(), count), np.full(count, tube), cols)


def bent(size: tuple[float, float], counts: tuple[int, int], bend: float = 1.0, diagonal: str = "both") -> Form:
    """An open sheet of rows and columns that waves slowly."""

    def height(p: Array) -> Array:
        return bend * (np.sin(0.27 * p[:, 0] + 0.4) + 0.7 * np.cos(0.21 * p[:, 1] - 0.1 * p[:, 0]))

    return lambda rng: cloth(size, counts, height, diagonal)


def dish(outline: Array, spacing: float, depth: float, jitter: float = 0.35) -> Form:
    """An open, irregular sheet that sinks to its middle."""
    return lambda rng: sheet(outline, spacing, lambda p: depth * (p * p).sum(axis=1) / 100, rng, jitter)


def planes(normals: Array, offsets: Array) -> Callable[[Array], Array]:
    """Field of the intersection of half-spaces."""
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return lambda p: np.asarray((p @ unit.T - offsets).max(axis=1))


def carved(field: Callable[[Array], Array], reach: Bounds, spacing: float) -> Form:
    """A field's creased form by marching cubes, its vertices moved onto the creases."""
    low = (-reach[0] - 0.13, -reach[1] - 0.21, -reach[2] - 0.17)
    return lambda rng: sharpened(cubes(field, low, (reach[0] + 1, reach[1] + 1, reach[2] + 1), spacing), field)


def cut(count: int, normals: Array, offsets: Array, ratio: float = 1.0) -> Form:
    """A convex body bounded by planes: irregular triangles, optionally ``ratio`` times as dense at its top."""
    field = planes(normals, offsets)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def form(rng: np.random.Generator) -> Surface:
        way = irregular(count, rng) if ratio == 1 else uneven(count, ratio)
        at = 1 / (way @ unit.T / offsets).max(axis=1)
        return sharpened(globe(way, lambda _: at), field, 3)

    return form


def bars(p: Array) -> Array:
    """Three square bars through each other."""
    q = np.abs(p)
    one = [np.maximum(q[:, k] - 9.5, np.maximum(q[:, (k + 1) % 3], q[:, (k + 2) % 3]) - 3.6) for k in range(3)]
    return np.minimum.reduce(one)


def ziggurat(p: Array) -> Array:
    """Stacked square steps, each slightly rotated."""
    total = np.full(len(p), np.inf)
    for k, (half, low, high) in enumerate(((9, -8, -3), (6.4, -3.5, 2), (3.8, 1.5, 7))):
        c, s = np.cos(0.25 * k + 0.1), np.sin(0.25 * k + 0.1)
        x, z = c * p[:, 0] + s * p[:, 2], c * p[:, 2] - s * p[:, 0]
        step = np.maximum.reduce([np.abs(x) - half, np.abs(z) - half, p[:, 1] - high, low - p[:, 1]])
        total = np.minimum(total, step)
    return total


PYRAMID = np.array([(1, 0.6, 0.3), (-1, 0.6, -0.3), (-0.3, 0.6, 1), (0.3, 0.6, -1), (0, -1, 0)])
EIGHT = np.array([(x + 0.1, y + 0.05, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])

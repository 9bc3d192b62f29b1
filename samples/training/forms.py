"""Base forms made of grids and filled outlines: boxes, prisms, revolved and extruded forms, balls, and open sheets."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from surface import Array, Surface
from tessellation import fibonacci, filled, grid, hull_faces, outward, resampled, welded

Rng = np.random.Generator
Point = Sequence[float]


def box(size: Point, spacing: float, radius: float = 0.0, diagonal: str = "both") -> Surface:
    """A box with edges sharp, or rounded by a radius; six grids."""
    half, parts = np.asarray(size, dtype=float) / 2, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        n, m = (max(2, round(2 * half[k] / spacing)) for k in (u, v))
        for side in (-1, 1):
            b, a = np.meshgrid(
                np.linspace(-half[v], half[v], m + 1), np.linspace(-half[u], half[u], n + 1), indexing="ij"
            )
            points = np.zeros((a.size, 3))
            points[:, axis], points[:, u], points[:, v] = side * half[axis], a.ravel(), b.ravel()
            faces = grid(m + 1, n + 1, diagonal)
            parts.append((points, faces if side > 0 else faces[:, ::-1], np.stack([a.ravel(), b.ravel()], 1)))
    made = welded(parts, spacing)
    if not radius:
        return made
    inner = made.vertices.clip(radius - half, half - radius)
    out = made.vertices - inner
    return Surface(inner + radius * out / np.linalg.norm(out, axis=1, keepdims=True), made.faces, made.uv)


def prism(
    outline: Array,
    height: float,
    spacing: float,
    rng: Rng,
    top: Callable[[Array], Array] | None = None,
    diagonal: str = "both",
) -> Surface:
    """A counter-clockwise outline extruded along z; ``top`` is the height of its upper end above ``height``."""
    ring = resampled(np.asarray(outline, dtype=float), spacing, closed=True)
    rows = max(2, round(height / spacing)) + 1
    plane, cap = filled(ring, spacing, rng)
    lift = height + (top(plane) if top else np.zeros(len(plane)))
    reach = np.concatenate([[0], np.linalg.norm(np.diff(ring, axis=0), axis=1).cumsum()])
    z = np.linspace(0, 1, rows)[:, None] * lift[: len(ring)]
    side = np.concatenate([np.broadcast_to(ring, (rows, *ring.shape)), z[..., None]], -1).reshape(-1, 3)
    uv = np.stack([np.broadcast_to(reach, z.shape), z], -1).reshape(-1, 2)
    below = np.column_stack([plane, np.zeros(len(plane))])
    above = np.column_stack([plane, lift])
    return welded(
        [(side, grid(rows, len(ring), diagonal, ring=True), uv), (below, cap[:, ::-1], plane), (above, cap, plane)],
        spacing,
    )


def star(points: int, outer: float, inner: float) -> Array:
    """Corners of a star or, with inner equal to outer, a polygon of twice as many sides."""
    turn = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn)], 1)


def polygon(sides: int, radius: float) -> Array:
    turn = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    return radius * np.stack([np.cos(turn), np.sin(turn)], 1)


def gear(teeth: int, outer: float, inner: float) -> Array:
    """Outline of a gear with slanting flanks."""
    share = np.array([0.0, 0.22, 0.36, 0.64, 0.78])[1:]
    turn = (np.arange(teeth)[:, None] + share).ravel() * 2 * np.pi / teeth
    radius = np.tile([inner, outer, outer, inner], teeth)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn)], 1)


def turned(section: Sequence[Point], cols: int, spacing: float, rng: Rng, diagonal: str = "both") -> Surface:
    """A section of radii and heights, from bottom to top, rotated about y; discs close both ends."""
    line = resampled(np.asarray(section, dtype=float), spacing)
    turn = 2 * np.pi * np.arange(cols) / cols
    r, y = line[:, :1], np.broadcast_to(line[:, 1:], (len(line), cols))
    side = np.stack([r * np.sin(turn), y, r * np.cos(turn)], -1).reshape(-1, 3)
    reach = np.concatenate([[0], np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()])
    period = 2 * np.pi * float(line[:, 0].max())
    uv = np.stack(np.broadcast_arrays(period * turn / (2 * np.pi), reach[:, None]), -1).reshape(-1, 2)
    parts = [(side, grid(len(line), cols, diagonal, ring=True), uv)]
    for row, upward in ((0, False), (-1, True)):
        ring = line[row, 0] * np.stack([np.sin(turn), np.cos(turn)], 1)
        plane, cap = filled(ring, 2 * np.pi * line[row, 0] / cols, rng)
        disc = np.stack([plane[:, 0], np.full(len(plane), line[row, 1]), plane[:, 1]], 1)
        parts.append((disc, cap[:, ::-1] if upward else cap, plane))
    made = welded(parts, spacing)
    return Surface(made.vertices, made.faces, made.uv, period)


def curved(points: Sequence[Point], count: int) -> Array:
    """A smooth curve through points, sampled at the requested number of equidistant positions."""
    from scipy.interpolate import CubicSpline

    p = np.asarray(points, dtype=float)
    fine = CubicSpline(np.arange(len(p)), p)(np.linspace(0, len(p) - 1, 40 * len(p)))
    reach = np.concatenate([[0], np.linalg.norm(np.diff(fine, axis=0), axis=1).cumsum()])
    at = np.linspace(0, reach[-1], count)
    return np.stack([np.interp(at, reach, fine[:, k]) for k in range(p.shape[1])], 1)


def drawn(line: Array, radii: Array, cols: int, closed: bool = False, diagonal: str = "both") -> Surface:
    """A tube along a line; a closed one meets itself, an open one ends in points."""
    ahead = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0) if closed else np.gradient(line, axis=0)
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.empty_like(line)
    side[0] = np.cross(ahead[0], np.eye(3)[np.argmin(np.abs(ahead[0]))])
    for k in range(len(line)):
        before = side[k - 1] if k else side[0]
        here = before - ahead[k] * (before @ ahead[k])
        side[k] = here / np.linalg.norm(here)
    turn = 2 * np.pi * np.arange(cols) / cols + np.zeros((len(line), 1))
    if closed:  # distributes the rotation of the frame around a closed line along its length
        last = side[-1] - ahead[0] * (side[-1] @ ahead[0])
        off = np.arctan2(np.cross(side[0], last) @ ahead[0], side[0] @ last)
        turn = turn - off * (np.arange(len(line)) / len(line))[:, None]
    other = np.cross(ahead, side)
    out = np.cos(turn)[..., None] * side[:, None] + np.sin(turn)[..., None] * other[:, None]
    points = (line[:, None] + radii[:, None, None] * out).reshape(-1, 3)
    faces = grid(len(line), cols, diagonal, ring=True, closed=closed)
    reach = np.concatenate([[0], np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()])
    period = 2 * np.pi * float(radii.max())
    uv = np.stack(np.broadcast_arrays(period * np.arange(cols) / cols, reach[:, None]), -1).reshape(-1, 2)
    if not closed:
        ring, top = np.arange(cols), cols * (len(line) - 1)
        after = (ring + 1) % cols
        first = np.stack([np.full(cols, len(points)), after, ring], 1)
        last = np.stack([np.full(cols, len(points) + 1), top + ring, top + after], 1)
        tips = np.stack([line[0] - ahead[0] * radii[0] / 2, line[-1] + ahead[-1] * radii[-1] / 2])
        points, faces = np.vstack([points, tips]), np.vstack([faces, first, last])
        uv = np.vstack([uv, [(0, 0), (0, reach[-1])]])
    return outward(Surface(points, faces.astype(np.int32), uv, period))


def knot(turns: int, winds: int, count: int, radius: float = 10.0, wide: float = 4.0) -> Array:
    """A closed line that goes around a torus ``turns`` times while it winds ``winds`` times about its tube."""
    t = 2 * np.pi * np.arange(count) / count
    off = radius + wide * np.cos(winds * t)
    return np.stack([off * np.cos(turns * t), off * np.sin(turns * t), wide * np.sin(winds * t)], 1)


def globe(directions: Array, radius: Callable[[Array], Array]) -> Surface:
    """A star-shaped form: a distance for each direction; triangles between irregular points."""
    return Surface(directions * radius(directions)[:, None], hull_faces(directions))


def uneven(count: int, ratio: float = 9.0) -> Array:
    """Directions ``ratio`` times as dense (in area) at the top as below."""
    return fibonacci(count, lambda y: np.exp(np.log(ratio) * (y + 1) / 2))


def sheet(outline: Array, spacing: float, height: Callable[[Array], Array], rng: Rng, jitter: float = 0.35) -> Surface:
    """An open sheet over an outline, cut irregularly."""
    plane, faces = filled(resampled(np.asarray(outline, dtype=float), spacing, closed=True), spacing, rng, jitter)
    return Surface(np.column_stack([plane, height(plane)]), faces, plane)


def cloth(size: Point, counts: tuple[int, int], height: Callable[[Array], Array], diagonal: str = "both") -> Surface:
    """An open sheet of rows and columns."""
    v, u = np.meshgrid(np.linspace(0, size[1], counts[1]), np.linspace(0, size[0], counts[0]), indexing="ij")
    plane = np.stack([u.ravel(), v.ravel()], 1)
    return Surface(np.column_stack([plane, height(plane)]), grid(counts[1], counts[0], diagonal), plane)

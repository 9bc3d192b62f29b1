"""Ways to cut a surface into triangles: grids, irregular points, marching cubes, and finer versions of any of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, Delaunay, cKDTree
from skimage.measure import marching_cubes, points_in_poly
from surface import Array, Faces, Surface, summed

Field = Callable[[Array], Array]
Bounds = tuple[float, float, float]


def grid(rows: int, cols: int, diagonal: str, *, ring: bool = False, closed: bool = False) -> Faces:
    """Triangles of a grid of vertices; a ring closes along its columns, a closed grid also along its rows.

    Squares are cut along "one" diagonal, the "other", or "both" in turn.
    """
    i, j = np.meshgrid(np.arange(rows - (not closed)), np.arange(cols - (not ring)), indexing="ij")
    i, j = i.ravel(), j.ravel()
    right, down = (j + 1) % cols, (i + 1) % rows
    a, b, c, d = i * cols + j, i * cols + right, down * cols + right, down * cols + j
    one = {"one": np.ones(len(i), bool), "other": np.zeros(len(i), bool), "both": (i + j) % 2 == 0}[diagonal][:, None]
    first = np.where(one, np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    second = np.where(one, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.stack([first, second], 1).reshape(-1, 3).astype(np.int32)


def welded(parts: list[tuple[Array, Faces, Array]], spacing: float) -> Surface:
    """Parts (vertices, faces, uv) joined at common vertices, which keep the uv of the first part."""
    start = np.cumsum([0] + [len(part[0]) for part in parts])
    vertices, uv = np.vstack([part[0] for part in parts]), np.vstack([part[2] for part in parts])
    faces = np.vstack([part[1] + start[k] for k, part in enumerate(parts)])
    pairs = cKDTree(vertices).query_pairs(1e-6 * spacing, output_type="ndarray")
    home = np.arange(len(vertices))
    np.minimum.at(home, pairs.max(axis=1), pairs.min(axis=1))
    kept, place = np.unique(home, return_inverse=True)
    return outward(Surface(vertices[kept], place[faces].astype(np.int32), uv[kept]))


def outward(surface: Surface) -> Surface:
    """Faces flipped if their enclosed volume is negative."""
    corner = surface.vertices[surface.faces[:, 0]] - surface.vertices.mean(axis=0)
    if (corner * surface.crosses).sum() >= 0:
        return surface
    return Surface(surface.vertices, np.ascontiguousarray(surface.faces[:, ::-1]), surface.uv, surface.period)


def resampled(points: Array, spacing: float, *, closed: bool = False) -> Array:
    """Points along a polyline about ``spacing`` apart; its corners stay."""
    ends = np.vstack([points[1:], points[:1]]) if closed else points[1:]
    made = []
    for a, b in zip(points, ends, strict=False):
        count = max(1, round(float(np.linalg.norm(b - a)) / spacing))
        made.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.vstack(made if closed else [*made, points[-1:]])


def hex_points(low: Array, high: Array, spacing: float, jitter: float, rng: np.random.Generator) -> Array:
    """Points of a honeycomb over a rectangle, each moved by up to ``jitter`` spacings."""
    y = np.arange(low[1], high[1] + spacing, spacing * np.sqrt(3) / 2)
    x = np.arange(low[0], high[0] + spacing, spacing)
    grid_x = x[None, :] + (np.arange(len(y)) % 2)[:, None] * spacing / 2
    points = np.stack([grid_x, np.broadcast_to(y[:, None], grid_x.shape)], -1).reshape(-1, 2)
    return points + rng.uniform(-jitter, jitter, points.shape) * spacing


def filled(ring: Array, spacing: float, rng: np.random.Generator, jitter: float = 0.2) -> tuple[Array, Faces]:
    """Triangles inside a closed line of points, which come first among the vertices."""
    inner = hex_points(ring.min(axis=0), ring.max(axis=0), spacing, jitter, rng)
    inner = inner[points_in_poly(inner, ring)]
    inner = inner[cKDTree(ring).query(inner)[0] > 0.7 * spacing]
    points = np.vstack([ring, inner])
    faces = Delaunay(points).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where(area[:, None] < 0, faces[:, ::-1], faces)
    inside = points_in_poly((a + b + c) / 3, ring) & (np.abs(area) > 1e-3 * spacing**2)
    return points, faces[inside].astype(np.int32)


def fibonacci(count: int, density: Field | None = None) -> Array:
    """Directions spread evenly, or by a density over their height -1 to 1."""
    share = (np.arange(count) + 0.5) / count
    y = 2 * share - 1
    if density is not None:
        at = np.linspace(-1, 1, 2001)
        total = np.cumsum(density(at))
        y = np.interp(share, (total - total[0]) / (total[-1] - total[0]), at)
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    return np.stack([np.sqrt(1 - y * y) * np.sin(turn), y, np.sqrt(1 - y * y) * np.cos(turn)], 1)


def hull_faces(directions: Array) -> Faces:
    """Delaunay triangles between directions on a sphere, wound outward."""
    faces = ConvexHull(directions).simplices
    a, b, c = (directions[faces[:, k]] for k in range(3))
    inside_out = (np.cross(b - a, c - a) * a).sum(axis=1) < 0
    faces = np.where(inside_out[:, None], faces[:, ::-1], faces)
    return faces[np.lexsort(np.sort(faces, axis=1).T)].astype(np.int32)


def irregular(count: int, rng: np.random.Generator, rounds: int = 3) -> Array:
    """Random directions, slightly pushed away from their nearest neighbours."""
    points = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(rounds):
        _, near = cKDTree(points).query(points, k=7)
        away = points[:, None] - points[near[:, 1:]]
        push = (away / (away**2).sum(axis=2, keepdims=True).clip(1e-9, None)).sum(axis=1)
        points = points + push / count * 1.2
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points


def cubes(field: Field, low: Bounds, high: Bounds, spacing: Bounds | float, rounds: int = 3) -> Surface:
    """The zero level of a field by marching cubes; each round smooths the vertices along it."""
    step = np.broadcast_to(np.asarray(spacing, dtype=float), (3,))
    axes = [np.arange(a, b + s, s) for a, b, s in zip(low, high, step, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    values = field(points.reshape(-1, 3)).reshape(points.shape[:3])
    least = 0.06 * step.min()  # keep corners away from the surface, to avoid slivers
    values = np.where(np.abs(values) < least, np.where(values < 0, -least, least), values)
    vertices, faces, _, _ = marching_cubes(values, 0.0)
    surface = Surface(np.asarray(low) + vertices * step, faces.astype(np.int32))
    return outward(evened(surface, field, rounds, float(step.min())) if rounds else surface)


def field_and_slope(field: Field, points: Array, step: float) -> tuple[Array, Array]:
    """A field and its gradient from four corners of a small tetrahedron."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=float)
    values = np.stack([field(points + step * corner) for corner in corners])
    return values.mean(axis=0), np.einsum("kn,kd->nd", values, corners) / (4 * step)


def evened(surface: Surface, field: Field, rounds: int, spacing: float) -> Surface:
    """Vertices moved towards the mean of their neighbours along the zero level, and projected back onto it."""
    one, two = np.concatenate([surface.edges, surface.edges[:, ::-1]]).T
    vertices = surface.vertices
    count = np.bincount(one, minlength=len(vertices))[:, None]
    for turn in range(rounds):
        value, slope = field_and_slope(field, vertices, 0.02 * spacing)
        square = (slope**2).sum(axis=1, keepdims=True).clip(0.05, None)
        middle = summed(one, vertices[two], len(vertices)) / count
        move = 0.6 * (middle - vertices) if turn < rounds - 1 else np.zeros_like(vertices)
        along = (move * slope).sum(axis=1, keepdims=True)
        vertices = vertices + move - ((along + value[:, None]) / square * slope).clip(-spacing / 2, spacing / 2)
    return Surface(vertices, surface.faces)


def sharpened(surface: Surface, field: Field, rounds: int = 2) -> Surface:
    """Vertices near a crease of the field moved onto it, the intersection of the planes of the faces around them."""
    vertices, faces = surface.vertices, surface.faces
    for _ in range(rounds):
        centre = vertices[faces].mean(axis=1)
        for _ in range(2):
            value, slope = field_and_slope(field, centre, 1e-3 * surface.edge)
            square = (slope**2).sum(axis=1, keepdims=True).clip(0.05, None)
            centre = centre - value[:, None] * slope / square
        normal = slope / np.sqrt(square)
        corner, owner = faces.ravel(), np.repeat(np.arange(len(faces)), 3)
        n = normal[owner]
        gap = (n * (centre[owner] - vertices[corner])).sum(axis=1)
        left = summed(corner, (n[:, :, None] * n[:, None, :]).reshape(-1, 9), len(vertices)).reshape(-1, 3, 3)
        right = summed(corner, n * gap[:, None], len(vertices))
        move = np.linalg.solve(left + 0.05 * np.eye(3), right[..., None])[..., 0]
        far = np.linalg.norm(move, axis=1, keepdims=True) / (0.45 * surface.edge)
        vertices = _moved(vertices, faces, move / far.clip(1, None), normal)
    return Surface(vertices, faces)


def _moved(vertices: Array, faces: Faces, move: Array, normals: Array) -> Array:
    """Vertices moved, unless that would make a face a needle or flip it."""
    stays = np.zeros(len(vertices), bool)
    for _ in range(20):
        made = Surface(np.where(stays[:, None], vertices, vertices + move), faces)
        bad = (made.thinness < 0.12) | ((made.face_normals * normals).sum(axis=1) < 0.3)
        if stays[faces[bad]].all():
            break
        stays[faces[bad]] = True
    return made.vertices


def halved(vertices: Array, faces: Faces) -> tuple[Array, Faces, NDArray[np.int64]]:
    """Each face cut into four at its edge midpoints, and the original face of each part."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], -1), axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    middle = (len(vertices) + number.reshape(-1, 3)).astype(np.int32)
    made = [middle] + [np.stack([faces[:, k], middle[:, k], middle[:, k - 1]], 1) for k in range(3)]
    four = np.stack(made, 1).reshape(-1, 3)
    return np.vstack([vertices, vertices[edges].mean(axis=1)]), four, np.repeat(np.arange(len(faces)), 4)

"""A head in the style of old coins: blended solids for the form, with chased hair.

The form is a signed field, negative inside; its surface comes from marching cubes and is smoothed; the
hair displaces it along its normals, finer than the cubes. x is the sitter's left, y up, z to the front of the face
until ``portrait`` turns the head.
"""

from __future__ import annotations

import numpy as np
from mesh_head import BUN, EYE, HAIR_CENTRE, ROLL, hair_parts, head
from mesh_parts import Array, Faces, Mesh, between, smooth_step, vertex_normals
from skimage.measure import marching_cubes

TURN = 62  # degrees from frontal view
CLOSE = ((EYE, 7.0), ((2.5, -18.8, 22.5), 5.5))  # centre and radius of the areas with the finest form
# (position, spacing) of the cubes in mm: fine at the face
ACROSS = ((0, 0.95), (12, 1.05), (24, 1.25))
UPRIGHT = ((-50, 2.4), (-30, 1.6), (-24, 1.05), (-14, 0.95), (6, 0.95), (12, 1.2), (36, 1.3))
DEPTH = ((-44, 1.5), (0, 1.3), (12, 1.05), (34, 0.9))


def mirrored(points: Array) -> Array:
    """Mirror points of both halves of the head to its left."""
    return np.concatenate([np.abs(points[:, :1]), points[:, 1:]], axis=1)


def ruled(spacing: tuple[tuple[float, float], ...], start: float) -> Array:
    """Positions from ``start`` to the end of the table, with the spacing given there."""
    at, step = zip(*spacing, strict=True)
    places = [start]
    while places[-1] < at[-1]:
        places.append(places[-1] + float(np.interp(places[-1], at, step)))
    return np.array(places)


def cubes() -> Mesh:
    """Marching cubes on one half of the field, mirrored to the other."""
    half, y, z = ruled(ACROSS, 0.42), ruled(UPRIGHT, -49.0), ruled(DEPTH, -44.0)
    grid = np.meshgrid(half, y, z, indexing="ij")
    field = head(np.stack([a.ravel() for a in grid], 1)).reshape(grid[0].shape)
    field = np.concatenate([field[::-1], field])
    # keep corners of cubes away from the surface, to avoid slivers and sides that depend on rounding
    field = np.where(np.abs(field) < 0.05, np.where(field < 0, -0.05, 0.05), field)
    places, faces, _, _ = marching_cubes(field, 0.0)
    x = np.concatenate([-half[::-1], half])
    vertices = np.stack([np.interp(places[:, k], np.arange(len(a)), a) for k, a in enumerate((x, y, z))], 1)
    return vertices, faces.astype(np.int32)


def field_and_slope(points: Array, step: float = 0.02) -> tuple[Array, Array]:
    """The field and its gradient from four corners of a small tetrahedron."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=float)
    values = np.stack([head(points + step * corner) for corner in corners])
    return values.mean(axis=0), np.einsum("kn,kd->nd", values, corners) / (4 * step)


def evened(vertices: Array, faces: Faces, rounds: int) -> Array:
    """Vertices smoothed along the surface and projected back onto it."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = np.bincount(ends[:, 0], minlength=len(vertices))[:, None]
    for turn in range(rounds):
        total = np.stack([np.bincount(ends[:, 0], vertices[ends[:, 1], k], len(vertices)) for k in range(3)], 1)
        value, slope = field_and_slope(vertices)
        square = (slope**2).sum(axis=1, keepdims=True).clip(0.05, None)
        move = 0.6 * (total / count - vertices) if turn < rounds - 1 else np.zeros_like(vertices)
        along = (move * slope).sum(axis=1, keepdims=True)
        vertices = vertices + move - ((along + value[:, None]) / square * slope).clip(-0.5, 0.5)
    return vertices


def refined(vertices: Array, faces: Faces) -> Mesh:
    """Faces around the eyes and the mouth cut into four, those along the border of these areas into two."""
    fold = mirrored(vertices)
    inside = np.logical_or.reduce([np.linalg.norm(fold - centre, axis=1) < reach for centre, reach in CLOSE])
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], -1)  # edge k starts at corner k
    key = (ends.min(axis=2).astype(np.int64) * len(vertices) + ends.max(axis=2)).ravel()
    cut = inside[ends].all(axis=2)
    edges, number = np.unique(key[cut.ravel()], return_inverse=True)
    middle = np.zeros(faces.shape, dtype=np.int64)
    middle[cut] = len(vertices) + number
    halves = (vertices[edges // len(vertices)] + vertices[edges % len(vertices)]) / 2
    made = [faces[~cut.any(axis=1)]]
    whole = cut.all(axis=1)
    m, f = middle[whole], faces[whole]
    made += [m] + [np.stack([f[:, k], m[:, k], m[:, k - 1]], 1) for k in range(3)]
    for k in range(3):  # two corners inside cut one edge, never two
        one = cut[:, k] & ~whole
        start, end, far, half = faces[one, k], faces[one, k - 2], faces[one, k - 1], middle[one, k]
        made += [np.stack([start, half, far], 1), np.stack([half, end, far], 1)]
    return np.vstack([vertices, halves]), np.vstack(made).astype(np.int32)


def groove(phase: Array) -> Array:
    """Round locks with sharp creases between them: 1 on a lock, 0 in a crease, one lock per unit of phase."""
    return np.abs(np.cos(np.pi * phase)) ** 0.8


def polar(points: Array, centre: Array) -> tuple[Array, Array, Array]:
    """Distance along the axis to the bun, distance from it, and angle around it."""
    axis = (BUN - HAIR_CENTRE) / np.linalg.norm(BUN - HAIR_CENTRE)
    rest = points - centre
    up = np.cross(axis, [1.0, 0, 0])
    a, b = rest[:, 0], rest @ up
    return rest @ axis, np.hypot(a, b), np.arctan2(a, b)


def along_roll(points: Array) -> tuple[Array, Array]:
    """Arc length along the roll of hair, and angle around it, of the nearest point on its centre line."""
    fold = mirrored(points)
    t = np.linspace(0, len(ROLL) - 1, 121)
    line = np.stack([np.interp(t, np.arange(len(ROLL)), ROLL[:, k]) for k in range(3)], 1)
    reach = np.concatenate([[0], np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()])
    weight = np.exp(-((fold[:, None] - line) ** 2).sum(axis=2) / 6 + 1e-300)
    weight = weight / weight.sum(axis=1, keepdims=True).clip(1e-12, None)
    middle, out = weight @ reach, fold - weight @ line
    return middle, np.arctan2(out[:, 1], np.hypot(out[:, 0], out[:, 2]) * np.sign(out[:, 0] + out[:, 2]))


def hair(points: Array) -> Array:
    """Height of the locks: combed to the bun on the crown, twisted in the roll, coiled on the bun; and the band."""
    parts = hair_parts(points)
    skin = np.minimum.reduce([parts["face"], parts["ear"]])
    nearest = np.minimum.reduce([parts["cap"], parts["roll"], parts["bun"]])
    share = {name: smooth_step(nearest - parts[name], -0.9, -0.1) for name in ("cap", "roll", "bun")}
    along, off, angle = polar(points, HAIR_CENTRE)
    turn = angle / (2 * np.pi)
    locks = 0.95 * groove(30 * turn + 0.35 * np.sin(0.28 * along)) * smooth_step(off, 6, 13) - 0.45
    place = np.abs(along + 2.6)
    band = 1.0 * (1 - smooth_step(place, 2.0, 2.9)) + 0.5 * between(place, 1.5, 1.9, 0.7) - 0.3
    cap = np.where(place < 3.4, band, locks)
    reach, around = along_roll(points)
    roll = 1.15 * groove(reach / 4.4 + 0.35 * around) - 0.5
    _, coil, spin = polar(points, BUN)
    bun = 0.95 * groove(coil / 3.3 + spin / (2 * np.pi)) - 0.45
    total = share["cap"] * cap + share["roll"] * roll + share["bun"] * bun
    return total * smooth_step(skin - nearest, -0.2, 0.8)


def pupils(points: Array) -> Array:
    """Depth of the drilled pupils."""
    gaze = mirrored(points) - EYE
    off = np.hypot(gaze[:, 0] - 0.3, gaze[:, 1] - 0.4)
    return -0.8 * (1 - smooth_step(off, 0.5, 1.7)) * between(gaze[:, 2], 3.5, 5.0, 0.1)


def portrait() -> Mesh:
    vertices, faces = cubes()
    vertices, faces = refined(evened(vertices, faces, 5), faces)
    vertices = evened(vertices, faces, 4)
    vertices = vertices + vertex_normals(vertices, faces) * (hair(vertices) + pupils(vertices))[:, None]
    c, s = np.cos(np.radians(TURN)), np.sin(np.radians(TURN))
    return vertices @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), faces

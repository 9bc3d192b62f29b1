"""Meshes with known surfaces."""

import numpy as np

import nmaptool as nm


def sphere(steps, radius=1.0):
    """A sphere of 8 steps^2 faces: an octahedron with each edge divided into ``steps``, pushed outwards."""
    corners = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    i, j = np.meshgrid(np.arange(steps + 1), np.arange(steps + 1), indexing="ij")
    inside = i + j <= steps
    weights = np.stack([steps - i - j, i, j], axis=-1)[inside] / steps
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(inside.sum())
    up = inside[:-1, :-1] & inside[1:, :-1] & inside[:-1, 1:]
    down = inside[1:, 1:]
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1)[up], np.stack([b, d, c], -1)[down]])
    octant = weights @ corners
    vertices, parts = [], []
    for k in range(8):
        sign = 1 - 2 * np.array([k & 1, k >> 1 & 1, k >> 2 & 1])
        vertices.append(octant * sign)
        parts.append((faces if sign.prod() > 0 else faces[:, ::-1]) + k * len(octant))
    points = np.concatenate(vertices)
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    return nm.Mesh(points, np.concatenate(parts).astype(np.int32))


def sheet(height, rows, cols, step=1.0):
    """A centred grid of (rows + 1) x (cols + 1) vertices with z = height(x, y), to be seen from +z."""
    y, x = np.mgrid[0 : rows + 1, 0 : cols + 1] * step
    x, y = x - cols * step / 2, y - rows * step / 2
    vertices = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).astype(float)
    a = (np.arange(rows)[:, None] * (cols + 1) + np.arange(cols)).ravel()
    b, c, d = a + 1, a + cols + 1, a + cols + 2
    faces = np.concatenate([np.stack([a, b, d], -1), np.stack([a, d, c], -1)])
    return nm.Mesh(vertices, faces.astype(np.int32))


def joined(*meshes):
    """Several meshes as one, with all their vertices and faces."""
    faces, count = [], 0
    for mesh in meshes:
        faces.append(mesh.faces + count)
        count += len(mesh.vertices)
    return nm.Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces).astype(np.int32))


def divided(mesh):
    """Divide each face into four at the midpoints of its edges."""
    a, b, c = (mesh.corners[:, k] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return nm.Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))


def angles(first, second):
    """Angles in degrees between unit vectors."""
    chord = np.linalg.norm(np.asarray(first, float) - second, axis=-1)
    return np.degrees(2 * np.arcsin((chord / 2).clip(0, 1)))

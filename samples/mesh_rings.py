"""Borromean rings: no two of the three are linked, but all three together are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from mesh_parts import Array, Faces, Mesh, torus_faces

RADIUS, TUBE = 24.0, 4.2  # mm
SWAY = 6.6  # height of a ring above and below the others: enough to keep ornaments apart
ROWS, COLUMNS = 144, 28  # whole numbers of both per stud, strand and band
Pattern = Callable[[Array, Array], Array]


def rope(along: Array, around: Array) -> Array:
    """Seven strands laid side by side."""
    return 0.9 * np.abs(np.sin(3.5 * around)) - 0.4 + 0 * along


def studs(along: Array, around: Array) -> Array:
    """Pyramids between two families of milled grooves."""
    u, v = 18 * along, 4 * around
    return 1.5 * np.minimum(np.abs(np.sin((u + v) / 2)), np.abs(np.sin((u - v) / 2))) - 0.5


def bundle(along: Array, around: Array) -> Array:
    """Reeds laid lengthwise, bound by nine turned bands."""
    reeds = 1.0 * np.abs(np.sin(3.5 * around)) - 0.6
    place = ((along * 9 / (2 * np.pi) + 0.5) % 1 - 0.5) * 16  # rows from the middle of a band
    return np.where(np.abs(place) < 5.4, 0.75 * np.abs(np.cos(np.pi * place / 4)) + 0.1, reeds)


def ring(which: int, pattern: Pattern, winding: int) -> tuple[Array, Faces]:
    """One ring; its grid winds around the tube ``winding`` times in a turn, so that strands follow the grid."""
    half_row, half_column = np.pi / ROWS, np.pi / COLUMNS
    along = 2 * half_row * np.arange(ROWS)[:, None]
    around = 2 * half_column * np.arange(COLUMNS)[None]
    height = pattern(along, around)
    faces = torus_faces(height, pattern(along + half_row, around + half_column))
    centre = np.pi / 2 + 2 * np.pi / 3 * which
    angle = along[:, 0] + centre + np.pi  # from the side that faces the centre of the three
    # the crossings are 30 and 90 degrees from that side, where this sine goes over, under, over, under
    line = np.stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), SWAY * np.sin(3 * along[:, 0])], -1)
    line[:, :2] += RADIUS / np.sqrt(3) * np.array([np.cos(centre), np.sin(centre)])
    forward = np.stack([-RADIUS * np.sin(angle), RADIUS * np.cos(angle), 3 * SWAY * np.cos(3 * along[:, 0])], -1)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    side = np.cross([0.0, 0.0, 1.0], forward)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(forward, side)
    place = (around + winding * along)[..., None]
    tube = (TUBE + height)[..., None]
    vertices = line[:, None] + tube * (np.cos(place) * side[:, None] + np.sin(place) * up[:, None])
    return vertices.reshape(-1, 3), faces


def rings() -> Mesh:
    made = [ring(which, *how) for which, how in enumerate(((studs, 0), (rope, 4), (bundle, 0)))]
    faces = np.vstack([faces + which * ROWS * COLUMNS for which, (_, faces) in enumerate(made)])
    return np.vstack([vertices for vertices, _ in made]), faces.astype(np.int32)

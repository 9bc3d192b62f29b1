"""Small meshes to render: a plate with bumps that faces the front, and options that render it quickly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mesh_files import obj

from nmaptool.types.mesh import Mesh

# x, y from -10 to 10, z from 0 to 2.5; all of it is visible from the front
SIDE = 20.0
# the plate fills the height of the image except for the margin; every machine has this renderer
QUICK = ("--size", "60x50", "--margin", "2px", "--renderer", "numpy")
PITCH = SIDE / 46


def plate(cells: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a dome with bumps on a square."""
    y, x = np.mgrid[-1 : 1 : (cells + 1) * 1j, -1 : 1 : (cells + 1) * 1j]
    z = 2 * (1 - x**2) * (1 - y**2) + 0.3 * (1 + np.cos(16 * x) * np.cos(15 * y)) / 2 + 0.1 * x
    vertices = np.stack([x * SIDE / 2, y * SIDE / 2, z - z.min()], axis=-1).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, up, both = corner + 1, corner + cells + 1, corner + cells + 2
    faces = np.stack([np.stack([corner, right, both], 1), np.stack([corner, both, up], 1)], axis=1)
    return vertices, faces.reshape(-1, 3).astype(np.int32)


def plate_mesh() -> Mesh:
    """The plate as a Mesh."""
    return Mesh(*plate(), name="plate.obj")


def quickly(*words: object) -> list[object]:
    """The arguments, plus those of `QUICK` whose flags they do not set."""
    return [*words, *(w for flag in QUICK[::2] if flag not in words for w in (flag, QUICK[QUICK.index(flag) + 1]))]


def write_plate(path: Path) -> Path:
    """Write the plate as OBJ."""
    path.write_bytes(obj(*plate()))
    return path

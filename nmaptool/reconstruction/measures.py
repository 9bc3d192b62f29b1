"""What became of a mesh: how much it holds."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces, cross


def volume_between(before: Float64, after: Float64, faces: Faces) -> float:
    """What a mesh holds more than before, in cubic units.

    The difference of the volumes of the cones from one point to all faces: for a closed mesh that of the volumes, and
    for an open one whose boundary stayed what lies between the two surfaces; neither depends on the point.

    Parameters
    ----------
    before, after : (N, 3) float64
    faces : (M, 3) int32
    """
    middle = before.mean(axis=0)
    return _cones(after - middle, faces) - _cones(before - middle, faces)


def volume(vertices: Float64, faces: Faces) -> float:
    """Of a closed mesh, in cubic units; below zero where it is wound inside out."""
    return _cones(vertices - vertices.mean(axis=0), faces)


def _cones(vertices: Float64, faces: Faces) -> float:
    a, b, c = (vertices.take(faces[:, k], axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, cross(b, c))) / 6

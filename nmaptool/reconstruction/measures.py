"""Measure the volume of a mesh before and after."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces, cross


def volume_between(before: Float64, after: Float64, faces: Faces) -> float:
    """Return the increase of a mesh's volume, in cubic units.

    It is the difference of the volumes of the cones from one point to all faces. For a closed mesh, that is the
    difference of the volumes; for an open mesh whose boundary did not move, it is the volume between the two surfaces.
    Neither depends on the point.

    Parameters
    ----------
    before, after : (N, 3) float64
    faces : (M, 3) int32
    """
    middle = before.mean(axis=0)
    return _cones(after - middle, faces) - _cones(before - middle, faces)


def volume(vertices: Float64, faces: Faces) -> float:
    """Return the volume of a closed mesh, in cubic units; negative if its faces are wound inside out."""
    return _cones(vertices - vertices.mean(axis=0), faces)


def _cones(vertices: Float64, faces: Faces) -> float:
    a, b, c = (vertices.take(faces[:, k], axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, cross(b, c))) / 6

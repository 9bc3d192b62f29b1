"""Axes that rotate with a mesh, so results computed along them do not depend on its orientation."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import FaceGeometry


def principal_axes(geometry: FaceGeometry) -> Float64:
    """Return the axes of inertia of a surface, each pointing in the direction of its skew.

    Returns
    -------
    (3, 3) float64
        Orthonormal, one axis per row, the longest first; possibly left-handed, so a mirrored mesh has mirrored axes.
        For symmetric meshes, such as a ball or a box, some axes are arbitrary and depend on rounding.
    """
    share = geometry.areas / geometry.areas.sum()
    place = geometry.centroids - share @ geometry.centroids
    place /= np.abs(place).max() or 1.0  # 0 for a single face
    axes: Float64 = np.linalg.eigh((place * share[:, None]).T @ place)[1].T[::-1]
    skew = share @ (place @ axes.T) ** 3
    return axes * np.where(skew < 0, -1, 1)[:, None]

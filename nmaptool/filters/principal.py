"""Axes that turn with a mesh, so that what is counted along them does not depend on how the mesh lies."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import FaceGeometry


def principal_axes(geometry: FaceGeometry) -> Float64:
    """The axes of inertia of a surface, each pointing to where it is skewed to.

    Returns
    -------
    (3, 3) float64
        Orthonormal, an axis a row, the longest first; possibly left-handed, so that a mirrored mesh has mirrored axes.
        Where a mesh is symmetric, as a ball or a box is, some of them are as good as any others and follow the
        rounding.
    """
    share = geometry.areas / geometry.areas.sum()
    place = geometry.centroids - share @ geometry.centroids
    place /= np.abs(place).max() or 1.0  # a single face lies in its own middle
    axes: Float64 = np.linalg.eigh((place * share[:, None]).T @ place)[1].T[::-1]
    skew = share @ (place @ axes.T) ** 3
    return axes * np.where(skew < 0, -1, 1)[:, None]

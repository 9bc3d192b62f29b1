"""Convert height fields to and from the samples in a file, at the centres of the pixels or at their corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import corner_mean, touching_vertices
from nmaptool.core.nearest import nearest_places
from nmaptool.types.height import Height
from nmaptool.types.picture import Frame

# alpha of a surface corner whose pixel to the lower right is not surface, and the threshold between it and 1
_CORNER_ONLY = 0.5
_PIXEL_TOO = 0.75


class Samples(NamedTuple):
    """The samples of a height field that a file stores.

    Attributes
    ----------
    z_mm : (h, w) float64
        0 where alpha is 0.
    alpha : (h, w) float32 or None
        None if the surface covers all pixels.
    """

    z_mm: Float64
    alpha: Float32 | None


def center_samples(height: Height) -> Samples:
    """Return heights at the (H, W) pixel centres, means of their corners; alpha is 1 on the surface, 0 outside."""
    z_mm = np.where(height.domain, corner_mean(height.z_mm), 0)
    return Samples(z_mm, None if height.domain.all() else height.domain.astype(np.float32))


def corner_samples(height: Height) -> Samples:
    """Return the heights at the (H+1, W+1) corners of the pixels, unchanged.

    Alpha is 1 where the pixel to the corner's lower right belongs to the surface, 0.5 where only other pixels at the
    corner do, and 0 where none does. It states exactly which pixels are surface and shows every corner with a height.
    """
    if height.domain.all():
        return Samples(height.z_mm, None)
    touching = height.vertex_mask
    alpha = np.where(touching, np.float32(_CORNER_ONLY), np.float32(0))
    alpha[:-1, :-1][height.domain] = 1
    return Samples(np.where(touching, height.z_mm, 0), alpha)


def height_of_centers(
    name: str, z_mm: Float64, alpha: Float32 | None, pitch_mm: float | None, *, with_gaps: bool = False
) -> Height:
    """Make a height field from heights at centres, which must be defined everywhere unless ``with_gaps``.

    Raises
    ------
    InputError
        If some are NaN, infinite or transparent, or the size of a pixel is not known.
    """
    if alpha is not None:
        z_mm = np.where(alpha <= 0, np.nan, z_mm)
    rows, cols = z_mm.shape
    known = np.isfinite(z_mm)
    if with_gaps and known.any() and not known.all():
        z_mm = z_mm.copy()
        z_mm[~known] = z_mm[nearest_places(known, ~known)]
        vertices = np.where(touching_vertices(known), to_vertices(z_mm), 0)
        return Height(vertices, known, Frame(rows, cols, pitch_mm))
    _check_finite(name, z_mm)
    return Height(to_vertices(z_mm), np.ones((rows, cols), bool), Frame(rows, cols, pitch_mm))


def height_of_corners(name: str, z_mm: Float64, lower_right: Mask, pitch_mm: float | None) -> Height:
    """Make a height field from heights at the corners of its pixels.

    Parameters
    ----------
    name : str
        Name for messages.
    z_mm : (H+1, W+1) float64
    lower_right : (H+1, W+1) bool
        Whether the pixel to the corner's lower right belongs to the surface.
    pitch_mm : float or None

    Raises
    ------
    InputError
        If there are fewer than 2 x 2 corners, a height on the surface is NaN or infinite, no pixel is surface, or the
        size of a pixel is not known.
    """
    rows, cols = z_mm.shape
    if min(rows, cols) < 2:
        raise InputError(f"{name}: holds heights at {cols} x {rows} corners; at least 2 x 2 are needed")
    domain = lower_right[:-1, :-1].copy()
    z_mm = np.where(touching_vertices(domain), z_mm, 0)
    _check_finite(name, z_mm)
    return Height(z_mm, domain, Frame(rows - 1, cols - 1, pitch_mm))


def lower_right_of(alpha: Float32 | None, shape: tuple[int, ...]) -> Mask:
    """(h, w) bool: corners whose pixel to the lower right belongs to the surface, by the alpha of `corner_samples`."""
    return np.ones(shape, bool) if alpha is None else np.asarray(alpha > _PIXEL_TOO)


def to_vertices(centre: Float64) -> Float64:
    """(H+1, W+1) heights at corners from (H, W) at centres: means of neighbours, extrapolated linearly at the edges.

    >>> to_vertices(np.array([[0.0, 1.0], [0.0, 1.0]]))[0].tolist()
    [-0.5, 0.5, 1.5]
    """
    for axis, count in enumerate(centre.shape):
        around = [(1, 1) if i == axis else (0, 0) for i in range(2)]
        if count > 1:
            centre = np.pad(centre, around, mode="reflect", reflect_type="odd")
        else:
            centre = np.pad(centre, around, mode="edge")
    return corner_mean(centre)


def _check_finite(name: str, z_mm: Float64) -> None:
    if not np.isfinite(z_mm).all():
        raise InputError(f"{name}: holds NaN or infinite heights; a curved background must be defined everywhere")

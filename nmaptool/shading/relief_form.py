"""Everything about a field that its colours depend on, besides the viewer: slopes, light, recesses and colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field
from nmaptool.shading.recesses import recess_share
from nmaptool.shading.seen_light import SeenLight, seen_light
from nmaptool.shading.texture import colored

# light below the surface travels at most this share of the picture's longer side; so much of it comes from there
_FARTHEST, _SCATTERED = 0.012, 0.5


@dataclass(frozen=True, eq=False)
class ReliefForm:
    """What does not depend on the viewer.

    Attributes
    ----------
    slopes : (h, w, 2) float32
        To the right and up.
    soft_slopes : (h, w, 2) float32
        The same for scattered light.
    piece, table : SeenLight
        Light on the piece, and around it.
    recess : (h, w) float32
    color : (h, w, 3) or (3,) float32
    """

    slopes: Float32
    soft_slopes: Float32
    piece: SeenLight
    table: SeenLight
    recess: Float32
    color: Float32


def relief_form(field: Field, material: Material, lights: Sequence[Light]) -> ReliefForm:
    """Return the slopes, light, recesses and colours of a field."""
    piece, table = seen_light(field, lights)
    slopes = _slopes(field)
    sigma = min(material.spread_mm / field.pitch_mm, _FARTHEST * max(field.shape))
    soft = slopes
    if sigma > 0.3:
        soft = _scattered(slopes, sigma)
        piece = replace(piece, lit=[_scattered(each, sigma) for each in piece.lit])
    recess = recess_share(field, piece.sky, material.tarnish)
    return ReliefForm(slopes, soft, piece, table, recess, colored(field, material))


def _slopes(field: Field) -> Float32:
    z = field.z_mm
    scale = np.float32(0.5 / field.pitch_mm)
    across, up = z[:, 1:] - z[:, :-1], z[:-1] - z[1:]
    out = np.empty((*field.shape, 2), np.float32)
    np.multiply(across[:-1] + across[1:], scale, out=out[..., 0])
    np.multiply(up[:, :-1] + up[:, 1:], scale, out=out[..., 1])
    return out


def _scattered(values: Float32, sigma: float) -> Float32:
    """Values of which a part comes from around."""
    import cv2

    around = cv2.GaussianBlur(values, (0, 0), sigma, borderType=cv2.BORDER_REFLECT_101)
    return np.asarray(values + np.float32(_SCATTERED) * (around - values), np.float32)


def normals(slopes: Float32) -> tuple[Float32, Float32, Float32]:
    """x, y and z of unit normals, from (..., 2) slopes."""
    p, q = slopes[..., 0], slopes[..., 1]
    nz = np.asarray(1 / np.sqrt(1 + p * p + q * q), np.float32)
    return -p * nz, -q * nz, nz

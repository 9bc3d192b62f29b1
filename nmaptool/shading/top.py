"""A picture from straight above, to scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.parallel import for_each_band
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field
from nmaptool.shading.recesses import recess_share
from nmaptool.shading.seen_light import SeenLight, seen_light
from nmaptool.shading.surface import Facets, irradiance, radiance
from nmaptool.shading.texture import colored

_BAND = 48


def top_view(field: Field, material: Material, lights: Sequence[Light], backdrop: Float32) -> Float32:
    """(h, w, 3) float32 linear light.

    Parameters
    ----------
    field : Field
    material : Material
    lights : sequence of Light
    backdrop : (3,) float32
        Colour of what the piece lies on.
    """
    piece, table = seen_light(field, lights)
    recess = recess_share(field, piece.sky)
    color = colored(field, material)
    z = field.z_mm
    pitch = np.float32(1 / (2 * field.pitch_mm))
    out = np.empty((*field.shape, 3), np.float32)

    def shade(band: slice) -> None:
        corners = z[band.start : band.stop + 1]
        across, up = corners[:, 1:] - corners[:, :-1], corners[:-1] - corners[1:]
        p, q = (across[:-1] + across[1:]) * pitch, (up[:, :-1] + up[:, 1:]) * pitch
        nz = 1 / np.sqrt(1 + p * p + q * q)
        own = color[band] if color.ndim == 3 else color
        zero, one = np.float32(0), np.float32(1)
        facets = Facets(
            (-p * nz, -q * nz, nz),
            (zero, zero, one),
            [each[band] for each in piece.lit],
            piece.sky[band],
            recess[band],
            own,
        )
        out[band] = radiance(facets, material, lights)

    for_each_band(field.shape[0], _BAND, shade)
    return out if field.is_whole else _on_backdrop(out, field, table, lights, backdrop)


def _on_backdrop(
    picture: Float32, field: Field, table: SeenLight, lights: Sequence[Light], backdrop: Float32
) -> Float32:
    """The picture in front of what the piece lies on, which is matt and level."""
    zero, one = np.float32(0), np.float32(1)
    level = Facets((zero, zero, one), (zero, zero, one), table.lit, table.sky, np.zeros_like(table.sky), backdrop)
    ground = irradiance(level, lights, backdrop) * backdrop
    cover = field.coverage[..., None]
    return np.asarray(ground + cover * (picture - ground), np.float32)

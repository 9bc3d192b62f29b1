"""A picture from straight above, to scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.parallel import for_each_band
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field
from nmaptool.shading.relief_form import normals, relief_form
from nmaptool.shading.seen_light import SeenLight
from nmaptool.shading.surface import Facets, irradiance, radiance

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
    form = relief_form(field, material, lights)
    out = np.empty((*field.shape, 3), np.float32)
    zero, one = np.float32(0), np.float32(1)

    def shade(band: slice) -> None:
        sharp = normals(form.slopes[band])
        facets = Facets(
            sharp,
            sharp if form.soft_slopes is form.slopes else normals(form.soft_slopes[band]),
            (zero, zero, one),
            [each[band] for each in form.piece.lit],
            form.piece.sky[band],
            form.recess[band],
            form.color[band] if form.color.ndim == 3 else form.color,
        )
        out[band] = radiance(facets, material, lights)

    for_each_band(field.shape[0], _BAND, shade)
    return out if field.is_whole else _on_backdrop(out, field, form.table, lights, backdrop)


def _on_backdrop(
    picture: Float32, field: Field, table: SeenLight, lights: Sequence[Light], backdrop: Float32
) -> Float32:
    """The picture in front of what the piece lies on, which is matt and level."""
    up = np.float32(0), np.float32(0), np.float32(1)
    level = Facets(up, up, up, table.lit, table.sky, np.zeros_like(table.sky), backdrop)
    ground = irradiance(level, lights, backdrop) * backdrop
    cover = field.coverage[..., None]
    return np.asarray(ground + cover * (picture - ground), np.float32)

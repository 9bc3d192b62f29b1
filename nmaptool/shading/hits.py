"""The colours of the points that a perspective picture sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field
from nmaptool.shading.relief_form import ReliefForm, normals, relief_form
from nmaptool.shading.surface import Facets, radiance
from nmaptool.shading.table import table_light
from nmaptool.shading.viewpoint import Viewpoint

# pixels over which the direction of a wall is smoothed, and from which it takes its light
_WALL_PX, _BESIDE_PX = 7.0, 4.0
# OpenCV limits the sides of a picture of samples
_WIDE = 4096
# the table is darkest here, in longer sides
_FADES = 0.75


@dataclass(frozen=True, eq=False)
class Hits:
    """What the samples of a picture see.

    Attributes
    ----------
    x_mm, y_mm, z_mm : (h, w) float32
        From the middle of the field.
    on_piece, on_wall : (h, w) bool
    """

    x_mm: Float32
    y_mm: Float32
    z_mm: Float32
    on_piece: Mask
    on_wall: Mask


@dataclass(frozen=True, eq=False)
class Surroundings:
    """All that depends on places of a field and not on the camera.

    Attributes
    ----------
    field, material, lights, backdrop
    form : ReliefForm
    wall : (h, w, 2) float32
        Direction out of the piece, near its outline.
    """

    field: Field
    material: Material
    lights: Sequence[Light]
    backdrop: Float32
    form: ReliefForm
    wall: Float32


def surroundings(field: Field, material: Material, lights: Sequence[Light], backdrop: Float32) -> Surroundings:
    """Return what the colours of a field's points depend on, besides the camera."""
    import cv2

    soft = cv2.GaussianBlur(field.coverage, (0, 0), _WALL_PX, borderType=cv2.BORDER_CONSTANT)
    wall = np.dstack([-cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1)])
    return Surroundings(field, material, lights, backdrop, relief_form(field, material, lights), wall)


def shade_hits(hits: Hits, around: Surroundings, camera: Viewpoint) -> Float32:
    """(h, w, 3) linear light of each sample."""
    out = np.empty((*hits.x_mm.shape, 3), np.float32)
    for chosen, shade in (
        (~hits.on_piece, _table),
        (hits.on_piece & ~hits.on_wall, _top),
        (hits.on_wall, _wall),
    ):
        if chosen.any():
            out[chosen] = shade((hits.x_mm[chosen], hits.y_mm[chosen], hits.z_mm[chosen]), around, camera)
    return out


def _table(at: tuple[Float32, Float32, Float32], around: Surroundings, camera: Viewpoint) -> Float32:
    place = _places(around.field, at[0], at[1])
    lit = [_sampled(each, place, outside=1) for each in around.form.table.lit]
    sky = _sampled(around.form.table.sky, place, outside=1)
    far_mm = _FADES * max(around.field.shape) * around.field.pitch_mm
    return table_light(np.stack(at[:2], axis=1), lit, sky, around.lights, around.backdrop, far_mm)


def _top(at: tuple[Float32, Float32, Float32], around: Surroundings, camera: Viewpoint) -> Float32:
    form, place = around.form, _places(around.field, at[0], at[1])
    sharp = normals(_sampled(form.slopes, place))
    facets = Facets(
        sharp,
        sharp if form.soft_slopes is form.slopes else normals(_sampled(form.soft_slopes, place)),
        _to_eye(at, camera),
        [_sampled(each, place) for each in form.piece.lit],
        _sampled(form.piece.sky, place),
        _sampled(form.recess, place),
        _color(around, place),
    )
    return radiance(facets, around.material, around.lights)


def _wall(at: tuple[Float32, Float32, Float32], around: Surroundings, camera: Viewpoint) -> Float32:
    field = around.field
    place = _places(field, at[0], at[1])
    out = _sampled(around.wall, place)
    length = np.maximum(np.hypot(out[..., 0], out[..., 1]), np.float32(1e-6))
    nx, ny = out[..., 0] / length, out[..., 1] / length
    beside = (place[0] + np.float32(_BESIDE_PX) * nx, place[1] - np.float32(_BESIDE_PX) * ny)
    lit = [_sampled(each, beside) for each in around.form.table.lit]
    sky = _sampled(around.form.table.sky, beside)
    top = _sampled(field.centers_mm, place)
    share = ((at[2] - np.float32(field.back_mm)) / np.maximum(top - np.float32(field.back_mm), np.float32(1e-6))).clip(
        0, 1
    )
    # half the sky, less of it near the table, and light from the table
    sky = sky * (np.float32(0.5) + np.float32(0.4) * share)
    across = nx, ny, np.zeros_like(nx)
    facets = Facets(across, across, _to_eye(at, camera), lit, sky, np.zeros_like(sky), _color(around, place))
    return radiance(facets, around.material, around.lights)


def _color(around: Surroundings, place: tuple[Float32, Float32]) -> Float32:
    return around.form.color if around.form.color.ndim == 1 else _sampled(around.form.color, place)


def _to_eye(at: tuple[Float32, Float32, Float32], camera: Viewpoint) -> tuple[Float32, Float32, Float32]:
    x, y, z = (np.float32(eye) - here for eye, here in zip(camera.eye_mm, at, strict=True))
    length = 1 / np.sqrt(x * x + y * y + z * z)
    return x * length, y * length, z * length


def _places(field: Field, x: Float32, y: Float32) -> tuple[Float32, Float32]:
    """Columns and rows of points among the centres of the field's pixels."""
    rows, cols = field.shape
    scale = np.float32(1 / field.pitch_mm)
    return x * scale + np.float32(cols / 2 - 0.5), np.float32(rows / 2 - 0.5) - y * scale


def _sampled(values: Float32, place: tuple[Any, Any], outside: float | None = None) -> Float32:
    """(n,) or (n, channels) values at places; beyond the edge those of the edge, or ``outside``."""
    import cv2

    count = len(place[0])
    rows = -(-count // _WIDE)
    maps = [np.zeros(rows * _WIDE, np.float32) for _ in place]
    for one, given in zip(maps, place, strict=True):
        one[:count] = given
    border = cv2.BORDER_REPLICATE if outside is None else cv2.BORDER_CONSTANT
    x, y = (one.reshape(rows, _WIDE) for one in maps)
    found: NDArray[Any] = cv2.remap(values, x, y, cv2.INTER_LINEAR, borderMode=border, borderValue=outside or 0)
    return np.asarray(found.reshape(rows * _WIDE, *values.shape[2:])[:count], np.float32)

"""A perspective picture of a piece on a table, from its heights.

On an upright picture plane, all that a column sees lies in one vertical plane. Heights are sampled along these planes
from near to far; a sample is seen if it appears above all nearer ones. So one pass finds what every column sees.
The result is then tilted into the picture of a camera that looks down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64, Mask, Srgb
from nmaptool.core.parallel import for_each_band
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field
from nmaptool.shading.hits import Hits, shade_hits, surroundings
from nmaptool.shading.tone import dithered
from nmaptool.shading.viewpoint import AZIMUTH_DEG, ELEVATION_DEG, Viewpoint, around_points, viewpoint

Indices: TypeAlias = NDArray[np.intp]
# samples across a pixel, and steps across a pixel of the field
_SAMPLES, _STEPS = 2, 1.0
_OPAQUE = 0.5
_BAND = 96
# shadows on the table are found so far around the piece, in its longer sides
_NEAR, _FAR = 0.04, 0.22


def iso_view(
    field: Field,
    material: Material,
    lights: Sequence[Light],
    backdrop: Float32,
    size_px: int,
    azimuth_deg: float = AZIMUTH_DEG,
    elevation_deg: float = ELEVATION_DEG,
    *,
    is_steady: bool = False,
) -> Srgb:
    """(h, w, 3) uint8 sRGB picture of a piece that lies on a table.

    Parameters
    ----------
    field : Field
    material : Material
    lights : sequence of Light
    backdrop : (3,) float32
        Colour of the table.
    size_px : int
        Longer side of the picture.
    azimuth_deg, elevation_deg : float
        Where the camera stands.
    is_steady : bool
        The size of the picture and the distance are the same for every azimuth.
    """
    import cv2

    field = _on_table(field, lights)
    camera = _camera(field, size_px, azimuth_deg, elevation_deg, is_steady)
    around = surroundings(field, material, lights, backdrop)
    plane, to_plane = _plane(camera)
    picture = np.empty((plane.cols, plane.rows, 3), np.uint8)

    def draw(band: slice) -> None:
        hits = _march(field, camera, plane, band)
        picture[band] = dithered(shade_hits(hits, around, camera))

    for_each_band(plane.cols, _BAND, draw)
    upright = np.ascontiguousarray(picture.swapaxes(0, 1)[::-1])
    large = (camera.cols * _SAMPLES, camera.rows * _SAMPLES)
    tilted = cv2.warpPerspective(
        upright, to_plane, large, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(cv2.resize(tilted, (camera.cols, camera.rows), interpolation=cv2.INTER_AREA), np.uint8)


@dataclass(frozen=True)
class _Plane:
    """Samples of an upright picture plane at distance 1."""

    left: float
    bottom: float
    per_col: float
    per_row: float
    cols: int
    rows: int


def _plane(camera: Viewpoint) -> tuple[_Plane, Float64]:
    """The part of the upright plane that a camera sees, and the homography from fine pixels to its samples."""
    tilt = camera.upright()
    edge = np.linspace(0, 1, 9)
    x, y = np.meshgrid(edge * camera.cols, edge * camera.rows)
    places = np.stack([x.ravel(), y.ravel(), np.ones(x.size)])
    seen = tilt @ places
    across, up = seen[0] / seen[2], seen[1] / seen[2]
    rows, cols = math.ceil(camera.rows * _SAMPLES), math.ceil(camera.cols * _SAMPLES)
    left, bottom = float(across.min()), float(up.min())
    plane = _Plane(left, bottom, (float(across.max()) - left) / cols, (float(up.max()) - bottom) / rows, cols, rows)
    # centres of samples and of pixels are at .5; the first row of the upright picture is its top
    to_samples = np.array(
        [
            [1 / plane.per_col, 0, -left / plane.per_col - 0.5],
            [0, -1 / plane.per_row, rows - 0.5 + bottom / plane.per_row],
            [0, 0, 1.0],
        ]
    )
    fine = np.array([[1 / _SAMPLES, 0, 0.5 / _SAMPLES], [0, 1 / _SAMPLES, 0.5 / _SAMPLES], [0, 0, 1.0]])
    return plane, to_samples @ tilt @ fine


def _on_table(field: Field, lights: Sequence[Light]) -> Field:
    """The field with room around it for its shadow."""
    rise = float(field.centers_mm.max()) - field.back_mm
    lengths = [rise / math.tan(math.radians(light.elevation_deg)) / field.pitch_mm for light in lights]
    longer = max(field.shape)
    margin = math.ceil(min(max(1.1 * max(lengths, default=0.0), _NEAR * longer), _FAR * longer))
    return replace(
        field,
        z_mm=np.pad(field.z_mm, margin, mode="edge"),
        coverage=np.pad(field.coverage, margin),
    )


def _outline_points(field: Field) -> Float64:
    """(n, 3) points around the piece in mm from the middle of the field, at its top and at its back."""
    rows, cols = field.shape
    inside = field.coverage > 0.5
    found_rows = np.flatnonzero(inside.any(axis=1))
    first, last = (inside.argmax(axis=1)[found_rows], cols - inside[:, ::-1].argmax(axis=1)[found_rows])
    x = np.concatenate([first, last]) - cols / 2
    y = rows / 2 - np.tile(found_rows, 2) - 0.5
    plan = np.stack([x, y], axis=1)[:: max(1, len(x) // 400)] * field.pitch_mm
    top = float(field.centers_mm[inside].max())
    return np.concatenate([np.column_stack([plan, np.full(len(plan), z)]) for z in (field.back_mm, top)])


def _camera(field: Field, size_px: int, azimuth_deg: float, elevation_deg: float, is_steady: bool) -> Viewpoint:
    points = _outline_points(field)
    if not is_steady:
        return viewpoint(points, size_px, azimuth_deg, elevation_deg)
    return viewpoint(around_points(points), size_px, azimuth_deg, elevation_deg)


def _march(field: Field, camera: Viewpoint, plane: _Plane, band: slice) -> Hits:
    """What the samples of some columns of the upright plane see."""
    import cv2

    rows, cols = field.shape
    pitch = field.pitch_mm
    reach = 0.5 * pitch * math.hypot(rows, cols)
    eye, level, right = camera.eye_mm, camera.level, camera.right
    middle = -float(eye @ level)
    step = pitch / _STEPS
    far = np.arange(middle - reach, middle + reach, step)
    across = plane.left + (np.arange(band.start, band.stop) + 0.5) * plane.per_col
    # the field's own columns and rows of each sample of the vertical planes
    x = (eye[0] + far * level[0]) + np.multiply.outer(across, far * right[0])
    y = (eye[1] + far * level[1]) + np.multiply.outer(across, far * right[1])
    col, row = (x / pitch + cols / 2).astype(np.float32), (rows / 2 - y / pitch).astype(np.float32)
    z = cv2.remap(field.z_mm, col, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    half = np.float32(0.5)
    cover = cv2.remap(field.coverage, col - half, row - half, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    on = cover >= _OPAQUE
    z = np.where(on, z, np.float32(field.back_mm))
    ahead = _at_edges(far.astype(np.float32), step, cover, on)
    slope = np.asarray((z - np.float32(eye[2])) / ahead, np.float32)
    first = _first_seen(np.maximum.accumulate(slope, axis=1), plane)
    up = (plane.bottom + (np.arange(plane.rows) + 0.5) * plane.per_row).astype(np.float32)
    distance, on_piece, on_wall = _distances(first, (slope, ahead, on), up, field.back_mm - float(eye[2]))
    z_mm = np.where(on_piece, np.float32(eye[2]) + up * distance, np.float32(field.back_mm))
    sideways = distance * across.astype(np.float32)[:, None]
    x_mm, y_mm = (
        np.float32(eye[axis]) + np.float32(level[axis]) * distance + np.float32(right[axis]) * sideways
        for axis in (0, 1)
    )
    return Hits(x_mm, y_mm, z_mm, on_piece, on_wall)


def _first_seen(highest: Float32, plane: _Plane) -> Indices:
    """The first sample of each vertical plane that appears at each row of the picture plane, or above it.

    Parameters
    ----------
    highest : (n, samples) float32
        The highest place of the samples so far.

    Returns
    -------
    (n, rows) int
        The number of samples where none does.
    """
    count = len(highest)
    # the first row whose centre lies above a sample
    above = np.floor((highest - np.float32(plane.bottom)) / np.float32(plane.per_row) + np.float32(0.5))
    order = above.clip(0, plane.rows).astype(np.intp) + np.arange(count)[:, None] * (plane.rows + 1)
    per_row = np.bincount(order.ravel(), minlength=count * (plane.rows + 1)).reshape(count, -1)
    return np.asarray(np.cumsum(per_row, axis=1)[:, : plane.rows])


def _at_edges(far: Float32, step: float, cover: Float32, on: Mask) -> Float32:
    """Distances of the samples; those beside an edge of the piece are moved to it."""
    ahead = np.broadcast_to(far, cover.shape).copy()
    for sign, here, there in ((-1, np.s_[:, 1:], np.s_[:, :-1]), (1, np.s_[:, :-1], np.s_[:, 1:])):
        beside = on[here] & ~on[there]
        inside, outside = cover[here][beside], cover[there][beside]
        ahead[here][beside] += np.float32(sign * step) * (inside - np.float32(_OPAQUE)) / (inside - outside)
    return ahead


def _distances(
    first: Indices, samples: tuple[Float32, Float32, Mask], up: Float32, back_mm: float
) -> tuple[Float32, Mask, Mask]:
    """Distance ahead of what each place of the picture plane sees; whether that is the piece, and a wall of it."""
    slope, ahead, on = (each.ravel() for each in samples)
    count = samples[0].shape[1]
    offset = np.arange(len(first))[:, None] * count
    here = np.minimum(first, count - 1) + offset
    before = np.maximum(first - 1, 0) + offset
    on_piece = on.take(here) & (first < count)
    on_wall = on_piece & ~on.take(before)
    low, high, near, far = slope.take(before), slope.take(here), ahead.take(before), ahead.take(here)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = ((up - low) / (high - low)).clip(0, 1)
        part[on_wall | ~np.isfinite(part)] = 1
        distance = np.where(on_piece, near + part * (far - near), np.float32(back_mm) / up)
    return np.asarray(distance, np.float32), on_piece, on_wall

"""A perspective picture of any mesh on a table, from its triangles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask, Srgb
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.render.numpy_raster import visible_faces
from nmaptool.shading.lamp_depth import seen_by_lamp
from nmaptool.shading.occlusion import sky_share
from nmaptool.shading.surface import Facets, radiance
from nmaptool.shading.table import table_light
from nmaptool.shading.texture import pattern
from nmaptool.shading.tone import dithered
from nmaptool.shading.viewpoint import AZIMUTH_DEG, ELEVATION_DEG, Viewpoint, around_points, viewpoint
from nmaptool.types.mesh import Faces, Mesh

_SAMPLES = 2
# an edge between faces that differ by more is sharp
_CREASE = math.cos(math.radians(40))
# shares of the sky that count as open and as fully recessed
_OPEN_SKY, _CLOSED_SKY = 0.96, 0.4
# share of the light that comes to a wall from the sky and the bright table
_BELOW = 0.55
# the table is darkest here, in diagonals
_FADES = 0.75


@dataclass(frozen=True, eq=False)
class _Model:
    """A mesh in mm that stands on the table, and the normal of each corner."""

    points: Float64
    faces: Faces
    corner_normals: Float32


def mesh_view(
    mesh: Mesh,
    material: Material,
    lights: Sequence[Light],
    backdrop: Float32,
    size_px: int,
    azimuth_deg: float = AZIMUTH_DEG,
    elevation_deg: float = ELEVATION_DEG,
    *,
    is_steady: bool = False,
) -> Srgb:
    """(h, w, 3) uint8 sRGB picture of a mesh that lies on a table, with z up.

    Parameters
    ----------
    mesh : Mesh
        Cleaned.
    material, lights, backdrop, size_px, azimuth_deg, elevation_deg, is_steady
        As for `nmaptool.shading.iso.iso_view`.
    """
    import cv2

    model = _model(mesh)
    framed = around_points(model.points) if is_steady else model.points
    camera = viewpoint(framed, size_px, azimuth_deg, elevation_deg)
    rows, cols = camera.rows * _SAMPLES, camera.cols * _SAMPLES
    xyz, on_mesh, normal = _seen(model, camera, rows, cols)
    lit = [seen_by_lamp(model.points, model.faces, light, xyz, normal).ravel() for light in lights]
    sky = _sky(camera, xyz, normal).ravel()
    color = pattern(material, *(np.ascontiguousarray(xyz[..., axis]) for axis in range(3)))
    points, table, chosen = xyz.reshape(-1, 3), ~on_mesh.ravel(), on_mesh.ravel()
    out = np.empty_like(points)
    far_mm = _FADES * float(np.hypot(*np.ptp(model.points[:, :2], axis=0)))
    out[table] = table_light(points[table], [each[table] for each in lit], sky[table], lights, backdrop, far_mm)
    facets = _facets(
        (points[chosen], normal.reshape(-1, 3)[chosen]),
        [each[chosen] for each in lit],
        sky[chosen],
        color.reshape(-1, 3)[chosen] if color.ndim == 3 else color,
        camera,
        material.tarnish,
    )
    out[chosen] = radiance(facets, material, lights)
    codes = dithered(out.reshape(rows, cols, 3))
    return np.asarray(cv2.resize(codes, (camera.cols, camera.rows), interpolation=cv2.INTER_AREA), np.uint8)


def _facets(
    place: tuple[Float32, Float32],
    lit: list[Float32],
    sky: Float32,
    color: Float32,
    camera: Viewpoint,
    tarnish: float,
) -> Facets:
    """Points of the mesh with their normals, ready to be shaded."""
    at, normal = place
    eye = camera.eye_mm.astype(np.float32) - at
    eye /= np.linalg.norm(eye, axis=1, keepdims=True)
    own = (np.float32(_BELOW) + np.float32(1 - _BELOW) * normal[:, 2]).clip(0.1, 1)
    recess = ((np.float32(_OPEN_SKY) - sky / own) / np.float32(_OPEN_SKY - _CLOSED_SKY)).clip(0, 1)
    recess = (recess + np.float32(tarnish)).clip(0, 1)
    axes = normal[:, 0], normal[:, 1], normal[:, 2]
    share = np.asarray(recess * recess * (3 - 2 * recess), np.float32)
    return Facets(axes, axes, (eye[:, 0], eye[:, 1], eye[:, 2]), lit, sky, share, color)


def _model(mesh: Mesh) -> _Model:
    points = mesh.vertices_mm
    low, high = points.min(axis=0), points.max(axis=0)
    points = points - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    geometry = mesh.geometry
    weighted = geometry.normals * geometry.areas[:, None]
    smooth = np.stack(
        [np.bincount(mesh.faces.ravel(), np.repeat(weighted[:, axis], 3), minlength=len(points)) for axis in range(3)],
        axis=1,
    )
    smooth = smooth / np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-300)
    corners = smooth[mesh.faces]
    own = geometry.normals[:, None, :]
    sharp = (corners * own).sum(axis=2, keepdims=True) < _CREASE
    return _Model(points, mesh.faces, np.where(sharp, own, corners).astype(np.float32))


def _seen(model: _Model, camera: Viewpoint, rows: int, cols: int) -> tuple[Float32, Mask, Float32]:
    """The point at each sample, whether it lies on the mesh or on the table, and its normal."""
    placed = camera.project(model.points)
    placed[:, :2] *= _SAMPLES
    placed[:, 2] = 1 / placed[:, 2]  # linear in the picture
    face = visible_faces(placed, model.faces, rows, cols)
    rays = _rays(camera, rows, cols)
    on_mesh = face >= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        along = -camera.eye_mm[2] / rays[..., 2]
    chosen = face[on_mesh]
    a, b, c = (model.points.take(model.faces[:, k].take(chosen), axis=0) for k in range(3))
    ray = rays[on_mesh]
    plane = np.cross(b - a, c - a)
    along[on_mesh] = (plane * (a - camera.eye_mm)).sum(axis=1) / _apart((plane * ray).sum(axis=1))
    # a ray that misses the table ends far away
    far = 50 * float(np.linalg.norm(camera.eye_mm))
    along = np.where((along > 0) & (along < far), along, far)
    xyz = camera.eye_mm + along[..., None] * rays
    normal = np.zeros((rows, cols, 3), np.float32)
    normal[..., 2] = 1
    weights = _weights(a, b, c, plane, xyz[on_mesh])
    smooth = (model.corner_normals[chosen] * weights[..., None]).sum(axis=1)
    # a surface is seen from outside, whatever its winding
    smooth *= np.where((smooth * ray).sum(axis=1, keepdims=True) > 0, -1, 1)
    normal[on_mesh] = smooth / np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-9)
    return xyz.astype(np.float32), on_mesh, normal


def _apart(values: Float64) -> Float64:
    """Values that are never zero."""
    return np.where(np.abs(values) < 1e-300, 1e-300, values)


def _weights(a: Float64, b: Float64, c: Float64, plane: Float64, at: Float64) -> Float64:
    """(n, 3) barycentric weights of points in triangles."""
    square = np.maximum((plane * plane).sum(axis=1), 1e-300)
    wb = (np.cross(at - a, c - a) * plane).sum(axis=1) / square
    wc = (np.cross(b - a, at - a) * plane).sum(axis=1) / square
    wb, wc = wb.clip(0, 1), wc.clip(0, 1)
    return np.stack([(1 - wb - wc).clip(0, 1), wb, wc], axis=1)


def _rays(camera: Viewpoint, rows: int, cols: int) -> Float64:
    """(rows, cols, 3) directions from the eye, of length 1 along its axis."""
    col = ((np.arange(cols) + 0.5) / _SAMPLES - camera.middle_px[0]) / camera.focal_px
    row = (camera.middle_px[1] - (np.arange(rows) + 0.5) / _SAMPLES) / camera.focal_px
    return camera.ahead + col[None, :, None] * camera.right + row[:, None, None] * camera.up


def _sky(camera: Viewpoint, xyz: Float32, normal: Float32) -> Float32:
    """Share of the sky that each sample sees, by the depths of the samples around it."""
    depth = (xyz - camera.eye_mm.astype(np.float32)) @ camera.ahead.astype(np.float32)
    middle = float(np.median(depth))
    seen = sky_share(np.ascontiguousarray(-depth), middle / camera.focal_px / _SAMPLES)
    facing = (normal @ -camera.ahead.astype(np.float32)).clip(0, 1)
    # a plane that is seen at an angle hides half of the sky beside the camera, but none of its own
    seen = (seen / (0.5 + 0.5 * facing)).clip(0, 1)
    return np.asarray(seen * (np.float32(_BELOW) + np.float32(1 - _BELOW) * normal[..., 2]), np.float32)

"""Cast shadows of a mesh: what a lamp sees of it."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.options.preview import Light
from nmaptool.render.numpy_raster import visible_faces
from nmaptool.shading.lights import direction
from nmaptool.types.mesh import Faces

_SIDE_PX = 1000
# offsets in pixels at which the lamp's picture is compared: their mean makes the edge of a shadow soft
_SOFT = [(x, y) for x in (-1.2, -0.4, 0.4, 1.2) for y in (-1.2, -0.4, 0.4, 1.2)]
# a surface is not in its own shadow within so many pixels of the lamp's picture
_BIAS_PX = 2.0
# cosine of the angle to the lamp below which its light fades out
_FADES_AT = 0.25


def seen_by_lamp(points: Float64, faces: Faces, light: Light, xyz: Float32, normal: Float32) -> Float32:
    """Share of a lamp that points see past a mesh.

    Parameters
    ----------
    points : (n, 3) float64
        Vertices in mm.
    faces : (m, 3) int32
    light : Light
    xyz : (h, w, 3) float32
        Points on the mesh or the table.
    normal : (h, w, 3) float32
        Their normals.

    Returns
    -------
    (h, w) float32
        0 to 1.
    """
    import cv2

    toward = direction(light)
    right = np.cross([0.0, 0.0, 1.0], toward) if toward[2] < 0.999 else np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(toward, right), toward], axis=1)
    placed = points @ axes
    low = placed.min(axis=0)
    pitch = float(np.ptp(placed[:, :2], axis=0).max()) / _SIDE_PX
    cols, rows = (int(side / pitch) + 1 for side in np.ptp(placed[:, :2], axis=0))
    placed[:, :2] = (placed[:, :2] - low[:2]) / pitch
    depth = _depth(placed, faces, rows, cols)
    own = xyz.reshape(-1, 3) @ axes.astype(np.float32)
    toward_lamp = normal.reshape(-1, 3) @ toward.astype(np.float32)
    facing = toward_lamp.clip(0.1, 1)
    # move along the normal, so that grazed surfaces do not hide themselves
    lift = np.float32(_BIAS_PX * pitch) * np.sqrt(1 - facing * facing) / facing + np.float32(0.6 * _BIAS_PX * pitch)
    here = (own[:, 2] + lift).reshape(xyz.shape[:2])
    col, row = (
        ((own[:, axis] - np.float32(low[axis])) * np.float32(1 / pitch)).reshape(xyz.shape[:2]) for axis in (0, 1)
    )
    seen = np.zeros(xyz.shape[:2], np.float32)
    for x, y in _SOFT:
        nearest = cv2.remap(
            depth,
            col + np.float32(x - 0.5),
            row + np.float32(y - 0.5),
            cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=-1e30,
        )
        seen += nearest <= here
    # on surfaces that turn away, whose own shadow is decided by rounding, the light fades out
    turned = (toward_lamp / np.float32(min(_FADES_AT, 0.5 * toward[2]))).clip(0, 1).reshape(seen.shape)
    return np.asarray(seen / np.float32(len(_SOFT)) * turned * turned * (3 - 2 * turned), np.float32)


def _depth(placed: Float64, faces: Faces, rows: int, cols: int) -> Float32:
    """Distance towards the lamp of what it sees at each pixel of its picture; far below where it sees nothing."""
    face = visible_faces(placed, faces, rows, cols)
    out = np.full((rows, cols), -1e30, np.float32)
    row, col = np.nonzero(face >= 0)
    a, b, c = (placed.take(faces[:, k].take(face[row, col]), axis=0) for k in range(3))
    plane = np.cross(b - a, c - a)
    steep = np.where(np.abs(plane[:, 2]) < 1e-300, 1e-300, plane[:, 2])
    away = (plane[:, 0] * (col + 0.5 - a[:, 0]) + plane[:, 1] * (row + 0.5 - a[:, 1])) / steep
    least, most = (pick.reduce([a[:, 2], b[:, 2], c[:, 2]]) for pick in (np.minimum, np.maximum))
    out[row, col] = (a[:, 2] - away).clip(least, most)
    return out

"""The camera of perspective pictures: it stands above the table and looks down at the piece."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64

# from the front, a little from the left: level metal then does not mirror the usual first light
AZIMUTH_DEG, ELEVATION_DEG = -112.0, 40.0
# distance from the middle of the piece, in radii: a long lens
_DISTANCE = 5.2
_MARGIN = 0.05


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A pinhole camera whose horizontal axis is level.

    Attributes
    ----------
    eye_mm : (3,) float64
    ahead, right, up : (3,) float64
        Unit vectors of the camera.
    focal_px : float
    middle_px : tuple of float
        Column and row, from the upper left corner, where the camera looks.
    rows, cols : int
        Size of the picture.
    """

    eye_mm: Float64
    ahead: Float64
    right: Float64
    up: Float64
    focal_px: float
    middle_px: tuple[float, float]
    rows: int
    cols: int

    @property
    def level(self) -> Float64:
        """(3,) unit vector ahead along the table."""
        return np.array([-self.right[1], self.right[0], 0.0])

    def project(self, points_mm: Float64) -> Float64:
        """(n, 3) column, row and distance along the axis of each point."""
        rel = points_mm - self.eye_mm
        far = rel @ self.ahead
        col = self.middle_px[0] + self.focal_px * (rel @ self.right) / far
        row = self.middle_px[1] - self.focal_px * (rel @ self.up) / far
        return np.stack([col, row, far], axis=-1)

    def upright(self) -> Float64:
        """(3, 3) float64: homography from pixels to places on an upright picture plane at distance 1.

        There, the columns are vertical planes of space: the first coordinate is to the right and the second up, both
        per distance ahead along the table.
        """
        col, row = self.middle_px
        focal = self.focal_px
        # the ray of a pixel is ahead + (c - col) / f right - (r - row) / f up; its parts along the three level axes
        pixel = np.array([[1 / focal, 0, -col / focal], [0, -1 / focal, row / focal], [0, 0, 1]])
        axes = np.stack([self.right, self.up, self.ahead], axis=1)
        return np.asarray(np.stack([self.right, np.array([0.0, 0.0, 1.0]), self.level]) @ axes @ pixel)


def viewpoint(
    corners_mm: Float64,
    size_px: int,
    azimuth_deg: float = AZIMUTH_DEG,
    elevation_deg: float = ELEVATION_DEG,
) -> Viewpoint:
    """Return a camera that sees all of the points.

    Parameters
    ----------
    corners_mm : (n, 3) float64
        Points around the piece.
    size_px : int
        Longer side of the picture.
    azimuth_deg, elevation_deg : float
        Where the camera stands, seen from the piece.
    """
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    middle = (corners_mm.min(axis=0) + corners_mm.max(axis=0)) / 2
    radius = float(np.linalg.norm(corners_mm - middle, axis=1).max())
    back = np.array([math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    eye = middle + _DISTANCE * radius * back
    plain = Viewpoint(eye, -back, right, np.cross(back, right), 1.0, (0.0, 0.0), 1, 1)
    seen = plain.project(corners_mm)[:, :2]
    low, high = seen.min(axis=0), seen.max(axis=0)
    span = (high - low) * (1 + 2 * _MARGIN)
    focal = size_px / float(span.max())
    cols, rows = (max(1, round(float(side) * focal)) for side in span)
    center = (low + high) / 2 * focal
    place = (cols / 2 - float(center[0]), rows / 2 - float(center[1]))
    return Viewpoint(eye, -back, right, np.cross(back, right), focal, place, rows, cols)


def around_points(points_mm: Float64) -> Float64:
    """(n, 3) points of the upright cylinder around points: what a turning piece fills."""
    middle = (points_mm.min(axis=0) + points_mm.max(axis=0)) / 2
    radius = float(np.hypot(*(points_mm - middle)[:, :2].T).max())
    turn = np.linspace(0, math.tau, 72, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1) * radius + middle[:2]
    ends = points_mm[:, 2].min(), points_mm[:, 2].max()
    return np.concatenate([np.column_stack([ring, np.full(len(ring), z)]) for z in ends])

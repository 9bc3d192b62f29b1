"""The camera: its direction, the framing of the mesh, and the projection of points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.options import BakeOptions
from nmaptool.types.mesh import Mesh

# smallest distance of a perspective camera from the mesh, as a share of the mesh's extent across the view
_CLEARANCE = 0.01


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera in its eye space: x right, y up, z towards the viewer, all in units of the mesh.

    Attributes
    ----------
    rotation : (3, 3) float64
        Rotates directions of the mesh to eye space.
    center : (3,) float64
        Point of the rotated mesh at the picture's centre; the picture plane passes through it.
    unit_per_px : float
        Size of a pixel on the picture plane.
    rows, cols : int
        Size of the picture.
    distance : float or None
        From the picture plane to the eye; None for an orthographic camera.
    """

    rotation: Float64
    center: Float64
    unit_per_px: float
    rows: int
    cols: int
    distance: float | None = None

    def to_eye(self, points: Float64) -> Float64:
        """Convert (..., 3) points of the mesh to eye space, with the picture's centre at the origin."""
        return np.asarray(points @ self.rotation.T - self.center)

    def project(self, points: Float64) -> Float64:
        """Project points of the mesh onto the picture.

        Parameters
        ----------
        points : (N, 3) float64

        Returns
        -------
        (N, 3) float64
            Column and row in px from the upper left corner, and nearness: larger is nearer, and it is
            linear across the picture along every straight line and plane.

        Raises
        ------
        UsageError
            If a point lies behind a perspective camera.
        """
        eye = self.to_eye(points)
        scale = np.full(len(eye), 1 / self.unit_per_px)
        nearness = eye[:, 2].copy()
        if self.distance is not None:
            ahead = self.distance - eye[:, 2]
            if not (ahead > 1e-6 * self.distance).all():
                raise UsageError("the camera is inside the mesh; use a larger `pitch` or a smaller `fov`")
            nearness = self.distance / ahead
            scale *= nearness
        return np.column_stack([self.cols / 2 + eye[:, 0] * scale, self.rows / 2 - eye[:, 1] * scale, nearness])

    def rays(self, col: Float64, row: Float64) -> Float64:
        """(..., 3) float64: directions from the surface to the eye at picture positions, scaled so that z is 1."""
        out = np.zeros((*np.shape(col), 3))
        out[..., 2] = 1
        if self.distance is not None:
            out[..., 0] = (self.cols / 2 - col) * (self.unit_per_px / self.distance)
            out[..., 1] = (row - self.rows / 2) * (self.unit_per_px / self.distance)
        return out

    def plane_points(self, col: Float64, row: Float64) -> Float64:
        """(..., 3) float64: picture positions as points of the picture plane in eye space."""
        out = np.zeros((*np.shape(col), 3))
        out[..., 0] = (col - self.cols / 2) * self.unit_per_px
        out[..., 1] = (self.rows / 2 - row) * self.unit_per_px
        return out


def view_rotation(azimuth: float, elevation: float, roll: float, up: str) -> Float64:
    """Rotation from mesh to eye space.

    Parameters
    ----------
    azimuth : float
        Degrees of the camera around the up axis, counter-clockwise seen from above; 0 is the front.
    elevation : float
        Degrees of the camera above the horizon; 90 looks straight down.
    roll : float
        Degrees by which the picture is rotated counter-clockwise.
    up : str
        ``y``: the front is seen from +z; ``z``: from -y.
    """
    rotation = _turn(0, 2, 0.0)
    if up == "z":
        rotation = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    for first, second, angle in ((2, 0, -azimuth), (1, 2, elevation), (0, 1, roll)):
        rotation = _turn(first, second, angle) @ rotation
    return rotation


def _turn(first: int, second: int, degrees: float) -> Float64:
    """Rotation from axis ``first`` towards axis ``second``; exact for quarter turns."""
    quarter, rest = divmod(degrees, 90)
    cosine, sine = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarter) % 4):
        cosine, sine = -sine, cosine
    out = np.eye(3)
    out[[first, second], [first, second]] = cosine
    out[second, first], out[first, second] = sine, -sine
    return out


def frame_camera(mesh: Mesh, options: BakeOptions, azimuth: float, elevation: float) -> Camera:
    """Make a camera that sees a mesh from a direction and shows all of it, unless ``pitch`` or ``target`` is given.

    Parameters
    ----------
    mesh : Mesh
        Cleaned.
    options : BakeOptions
    azimuth, elevation : float
        Degrees, see `view_rotation`.

    Raises
    ------
    UsageError
        If the margin leaves no room.
    InputError
        If the mesh has no extent across the view.
    """
    rows, cols = options.rows, options.cols
    rotation = view_rotation(azimuth, elevation, options.roll, options.up)
    turned = mesh.vertices @ rotation.T
    margin = options.margin.to_mm(1.0, max(rows, cols))  # in px
    room = np.array([cols - 2 * margin, rows - 2 * margin])
    if not (room > 0).all():
        raise UsageError(
            f"`margin='{options.margin}'`: leaves no room in {cols} x {rows} px; use a smaller one, such as "
            f"{min(rows, cols) / 10:g}px"
        )
    low, high = turned.min(axis=0), turned.max(axis=0)
    center = (low + high) / 2
    extent = (high - low)[:2].max()
    if not extent > 0:
        raise InputError(f"{mesh.name}: is seen exactly edge-on; choose another `view`")
    tangent = math.tan(math.radians(options.fov) / 2) * 2 / max(rows, cols)  # per px
    if options.fov:
        center[:2], distance = _fitted(turned - center * (0, 0, 1), room / 2 * tangent)
        # a spike towards the camera must not touch it
        distance = max(distance, float((high - low)[2] / 2 + _CLEARANCE * extent))
        unit_per_px = distance * tangent
    else:
        unit_per_px = float(((high - low)[:2] / room).max())
    if options.pitch is not None:
        unit_per_px = options.pitch.to_mm(1.0, 1) / mesh.mm_per_unit
    if options.target is not None:
        center = rotation @ np.array(options.target_point)
    return Camera(rotation, center, unit_per_px, rows, cols, unit_per_px / tangent if options.fov else None)


def _fitted(points: Float64, tangents: NDArray[np.float64]) -> tuple[Float64, float]:
    """Centre (x, y) and smallest distance from z = 0 at which an eye sees all points within the slopes ``tangents``."""
    depth = points[:, 2:] * tangents
    outer, inner = (points[:, :2] + depth).max(axis=0), (points[:, :2] - depth).min(axis=0)
    distance = float(((outer - inner) / (2 * tangents)).max())
    return (outer + inner) / 2, distance

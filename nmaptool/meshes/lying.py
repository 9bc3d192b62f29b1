"""Doubt the axis that points up: does a mesh lie down, or show its edge, in a front view?"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from nmaptool.types.mesh import Mesh

_SIDEWAYS = {"front", "back", "left", "right", "iso"}
_USUALLY_Z_UP = (".stl", ".ply", ".3mf")  # formats of scanners, CAD and printing
# a plate is thinner than this share of its other sides
_THIN = 0.35
# a mesh is tall if it is longer along one axis than along the others by this factor
_TALL = 1.15
# a bottom is flat if this share of the footprint faces down at the lowest level, within the next two
_FLAT_SHARE, _LEVEL, _LARGEST_TILT = 0.2, 0.02, math.cos(math.radians(5))
_ON_GROUND = 0.002
# one side of a plate is its back if its flat part is larger than that of the other side by this factor
_FLATTER = 1.1


def lying(mesh: Mesh, up: str, views: Iterable[str]) -> list[str]:
    """Doubts about the axis that points up, at most one, with the option that changes it.

    Parameters
    ----------
    mesh : Mesh
        Cleaned. It is not doubted if its file says that y points up.
    up : str
        The axis taken as up, ``y`` or ``z``.
    views : iterable of str
        Names of the views.

    Returns
    -------
    list of str
    """
    chosen = set(views)
    if mesh.up_from == "file" or not chosen & _SIDEWAYS:
        return []
    extent = np.ptp(mesh.vertices, axis=0)
    if chosen <= {"front", "back"}:
        depth = 2 if up == "z" else 1  # the axis along which the other choice would look
        across = min(extent[0], extent[3 - depth])
        if extent[depth] < _THIN * across:
            return [_edge_on(mesh, up)]
    if up == "z":
        return []
    reason = _standing_along_z(mesh, extent)
    return [f"the mesh {reason}; if it lies down in the maps, use `up='z'`"] if reason else []


def _edge_on(mesh: Mesh, up: str) -> str:
    if up == "z":
        return "the mesh is thin along z, so this view shows its edge; use `up='y'` or `view='top'`"
    behind, below = _flat_share(mesh, 1, 1), _flat_share(mesh, 1, -1)
    remedy = "`up='z'` or `view='top'`"
    if max(behind, below) > max(_FLAT_SHARE, _FLATTER * min(behind, below)):  # the flat side is the back
        remedy = "`up='z'`" if behind > below else "`view='top'`"
    return f"the mesh is thin along y, so this view shows its edge; use {remedy}"


def _standing_along_z(mesh: Mesh, extent: np.ndarray) -> str:
    """How the mesh stands along z; empty if it does not, or may as well stand along y."""
    x, y, z = extent
    lowest = mesh.vertices.min(axis=0)
    on_ground = np.abs(lowest) < _ON_GROUND * extent.max()
    bottom_y, bottom_z = _flat_share(mesh, 1, -1), _flat_share(mesh, 2, -1)
    if bottom_y > _FLAT_SHARE or (on_ground[1] and not on_ground[2]):
        return ""
    if bottom_z > max(_FLAT_SHARE, 3 * bottom_y) and z > 0.9 * y:
        return "stands on a flat bottom that faces -z"
    if z > _TALL * max(x, y) and (on_ground[2] > on_ground[1]):
        return "is tallest along z and stands on z = 0"
    if z > _TALL * max(x, y) and mesh.name.lower().endswith(_USUALLY_Z_UP):
        return "is tallest along z"
    return ""


def _flat_share(mesh: Mesh, axis: int, sign: int) -> float:
    """The area that faces along ``sign`` times an axis, at that end of the mesh, as a share of the footprint."""
    positions, geometry = mesh.vertices[:, axis], mesh.geometry
    end = positions.max() if sign > 0 else positions.min()
    near = np.abs(geometry.centroids[:, axis] - end) < _LEVEL * np.ptp(positions)
    facing = geometry.normals[:, axis] * sign > _LARGEST_TILT
    footprint = np.prod(np.delete(np.ptp(mesh.vertices, axis=0), axis))
    return float(geometry.areas[near & facing].sum() / footprint) if footprint > 0 else 0.0

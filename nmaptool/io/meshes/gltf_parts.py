"""The sets of triangles in a glTF: their corners, and their positions with morph targets and skins at rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.io.meshes.accessors import ANY_TYPES, INDEX_TYPES, Accessors, Column
from nmaptool.io.meshes.draco import DRACO, DracoColumn, DracoPart, draco_column, draco_part
from nmaptool.io.meshes.gltf_buffers import whole_number
from nmaptool.io.meshes.polygons import Integers, one_fan, one_strip

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_JOINT_TYPES, _FLOAT = (5121, 5123), 5126
_SETS = 8  # joints of at most 32 per vertex
_AT_ONCE = 1 << 14  # vertices
AnyColumn = Column | DracoColumn


@dataclass(frozen=True, eq=False)
class Part:
    """One set of triangles, read on demand.

    Attributes
    ----------
    vertices, corners : int
    mode : int
        4: triangles, 5: a strip, 6: a fan.
    positions : Column or DracoColumn
    indices : Column, DracoPart or None
        Corner indices; None if the vertices are the corners.
    targets : tuple of Column or None
        Morph targets; None for one that does not move positions.
    joints, weights : tuple of Column or DracoColumn
        Joint numbers and weights, in sets of four per vertex; empty without a skin.
    """

    vertices: int
    corners: int
    mode: int
    positions: AnyColumn
    indices: Column | DracoPart | None
    targets: tuple[Column | None, ...]
    joints: tuple[AnyColumn, ...]
    weights: tuple[AnyColumn, ...]

    @property
    def faces(self) -> int:
        """Number of triangles."""
        return self.corners // 3 if self.mode == _TRIANGLES else max(self.corners - 2, 0)

    def triangles(self) -> Integers:
        """(M, 3) int64 triangles; indices are not checked."""
        if isinstance(self.indices, DracoPart):
            return self.indices.triangles()
        corners = np.arange(self.vertices)
        if self.indices is not None:
            corners = self.indices.stored().reshape(-1).astype(np.int64)
        if self.mode == _TRIANGLES:
            return corners.reshape(-1, 3)
        return one_strip(corners) if self.mode == _STRIP else one_fan(corners)

    def points(self, weights: Sequence[float]) -> Float64:
        """(N, 3) float64 positions, moved by the morph targets with the given weights."""
        points = self.positions.values()
        for target, weight in zip(self.targets, weights, strict=False):
            if target is not None and weight != 0:
                points = points + weight * target.values()
        return points

    def skinned(self, points: Float64, matrices: Float64) -> tuple[Float64, Float64]:
        """Move each point by the mean of the joints' matrices (J, 4, 4), weighted for its vertex.

        Returns
        -------
        points : (N, 3) float64
        determinants : (N,) float64
            Negative where a vertex is mirrored.

        Raises
        ------
        IndexError
            If a vertex follows a joint that does not exist.
        """
        shares = np.concatenate([column.values() for column in self.weights], axis=1)
        joints = np.concatenate([column.stored().astype(np.int64) for column in self.joints], axis=1)
        joints[shares == 0] = 0  # an unused place may name any joint
        total = shares.sum(axis=1)
        shares[total == 0, 0] = 1
        shares /= np.where(total == 0, 1, total)[:, None]
        out, determinants = np.empty_like(points), np.empty(len(points))
        for start in range(0, len(points), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            mean = np.einsum("nk,nkij->nij", shares[part], matrices[joints[part]])
            out[part] = np.einsum("nij,nj->ni", mean[:, :3, :3], points[part]) + mean[:, :3, 3]
            determinants[part] = np.linalg.det(mean[:, :3, :3])
        return out, determinants


def part_of(accessors: Accessors, primitive: dict[str, Any]) -> Part | str:
    """Return a set of triangles, or what the primitive holds instead: ``points``, ``lines`` or nothing.

    Raises
    ------
    InputError
        If it is compressed and cannot be read.
    IndexError, KeyError, TypeError, ValueError
        If it is invalid.
    """
    mode = whole_number(primitive.get("mode", _TRIANGLES))
    attributes = primitive["attributes"]
    position = attributes.get("POSITION")
    if position is None:
        return ""
    if mode < _TRIANGLES:
        return "lines" if mode else "points"
    if mode > _FAN:
        raise ValueError
    extension = primitive.get("extensions", {}).get(DRACO)
    draco = None if extension is None else draco_part(accessors, primitive, extension)

    def column(name: str, shape: str, types: tuple[int, ...] = ANY_TYPES) -> AnyColumn:
        if draco is not None:
            found = draco_column(accessors, draco, extension, name, attributes[name], 3 if shape == "VEC3" else 4)
            if found is not None:
                return found
        return accessors.column(attributes[name], shape, types)

    positions = column("POSITION", "VEC3")
    indices, corners = _corners(accessors, primitive, positions.count) if draco is None else (draco, 3 * draco.faces)
    if mode == _TRIANGLES and corners % 3:
        raise ValueError
    targets = tuple(_target(accessors, target, positions.count) for target in primitive.get("targets", []))
    joints, weights = _skin_columns(column, attributes, positions.count)
    drawn = mode if draco is None else _TRIANGLES
    return Part(positions.count, corners, drawn, positions, indices, targets, joints, weights)


def _corners(accessors: Accessors, primitive: dict[str, Any], vertices: int) -> tuple[Column | None, int]:
    """The corner indices of a part, if it has any, and the number of corners."""
    given = primitive.get("indices")
    if given is None or not vertices:
        return None, vertices
    indices = accessors.column(given, "SCALAR", INDEX_TYPES)
    return indices, indices.count


def _target(accessors: Accessors, target: dict[str, Any], count: int) -> Column | None:
    if "POSITION" not in target:
        return None
    moved = accessors.column(target["POSITION"], "VEC3")
    if moved.count != count:
        raise ValueError
    return moved


def _skin_columns(
    column: Callable[[str, str, tuple[int, ...]], AnyColumn], attributes: dict[str, Any], count: int
) -> tuple[tuple[AnyColumn, ...], tuple[AnyColumn, ...]]:
    joints: list[AnyColumn] = []
    weights: list[AnyColumn] = []
    for k in range(_SETS):
        if f"JOINTS_{k}" not in attributes or f"WEIGHTS_{k}" not in attributes:
            break
        joints.append(column(f"JOINTS_{k}", "VEC4", _JOINT_TYPES))
        weights.append(column(f"WEIGHTS_{k}", "VEC4", (*_JOINT_TYPES, _FLOAT)))
        if joints[k].count != count or weights[k].count != count:
            raise ValueError
    return tuple(joints), tuple(weights)


def moved(points: Float64, matrix: Float64) -> Float64:
    """(N, 3) float64: points moved by a matrix (4, 4)."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])

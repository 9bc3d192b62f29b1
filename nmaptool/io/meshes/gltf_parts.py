"""The sets of triangles in a glTF: their corners, and their positions with morph targets and skins at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.io.meshes.accessors import INDEX_TYPES, Accessors, Column
from nmaptool.io.meshes.draco import DRACO, DracoPart, draco_part
from nmaptool.io.meshes.gltf_buffers import whole_number
from nmaptool.io.meshes.polygons import Integers, one_fan, one_strip

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_JOINT_TYPES, _FLOAT = (5121, 5123), 5126
_SETS = 8  # joints of at most 32 per vertex


@dataclass(frozen=True, eq=False)
class Part:
    """One set of triangles, read on demand.

    Attributes
    ----------
    vertices, corners : int
    mode : int
        4: triangles, 5: a strip, 6: a fan.
    positions : Column or DracoPart
    indices : Column or None
        Corner indices; None if the vertices are the corners, or for Draco.
    targets : tuple of Column or None
        Morph targets; None for one that does not move positions.
    joints, weights : tuple of Column
        Joint numbers and weights, in sets of four per vertex; empty without a skin.
    """

    vertices: int
    corners: int
    mode: int
    positions: Column | DracoPart
    indices: Column | None
    targets: tuple[Column | None, ...]
    joints: tuple[Column, ...]
    weights: tuple[Column, ...]

    @property
    def faces(self) -> int:
        """Number of triangles."""
        return self.corners // 3 if self.mode == _TRIANGLES else max(self.corners - 2, 0)

    @property
    def is_skinned(self) -> bool:
        """Whether the vertices follow joints."""
        return bool(self.joints) and isinstance(self.positions, Column)

    def triangles(self) -> Integers:
        """(M, 3) int64 triangles; indices are not checked."""
        if isinstance(self.positions, DracoPart):
            return self.positions.triangles()
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

    def blended(self, matrices: Float64) -> Float64:
        """(N, 4, 4) float64: the mean of the joints' matrices (J, 4, 4) for each vertex by its weights.

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
        out = np.zeros((self.vertices, 4, 4))
        for k in range(joints.shape[1]):
            out += shares[:, k, None, None] * matrices[joints[:, k]]
        return out


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
    compressed = primitive.get("extensions", {}).get(DRACO)
    given = primitive.get("indices")
    if compressed is not None:
        draco = draco_part(accessors, primitive, compressed)
        if draco is not None:
            return Part(draco.count, 3 * draco.faces, _TRIANGLES, draco, None, (), (), ())
    positions = accessors.column(position, "VEC3")
    indices = None
    if given is not None and positions.count:
        indices = accessors.column(given, "SCALAR", INDEX_TYPES)
    corners = positions.count if indices is None else indices.count
    if mode == _TRIANGLES and corners % 3:
        raise ValueError
    targets = tuple(_target(accessors, target, positions.count) for target in primitive.get("targets", []))
    joints, weights = _skin_columns(accessors, attributes, positions.count)
    return Part(positions.count, corners, mode, positions, indices, targets, joints, weights)


def _target(accessors: Accessors, target: dict[str, Any], count: int) -> Column | None:
    if "POSITION" not in target:
        return None
    moved = accessors.column(target["POSITION"], "VEC3")
    if moved.count != count:
        raise ValueError
    return moved


def _skin_columns(
    accessors: Accessors, attributes: dict[str, Any], count: int
) -> tuple[tuple[Column, ...], tuple[Column, ...]]:
    joints: list[Column] = []
    weights: list[Column] = []
    for k in range(_SETS):
        if f"JOINTS_{k}" not in attributes or f"WEIGHTS_{k}" not in attributes:
            break
        joints.append(accessors.column(attributes[f"JOINTS_{k}"], "VEC4", _JOINT_TYPES))
        weights.append(accessors.column(attributes[f"WEIGHTS_{k}"], "VEC4", (*_JOINT_TYPES, _FLOAT)))
        if joints[k].count != count or weights[k].count != count:
            raise ValueError
    return tuple(joints), tuple(weights)


def moved(points: Float64, matrices: NDArray[np.float64]) -> Float64:
    """(N, 3): points (N, 3) moved by one matrix (4, 4), or each by its own (N, 4, 4)."""
    if matrices.ndim == 2:
        return np.asarray(points @ matrices[:3, :3].T + matrices[:3, 3])
    return np.asarray(np.einsum("nij,nj->ni", matrices[:, :3, :3], points) + matrices[:, :3, 3])

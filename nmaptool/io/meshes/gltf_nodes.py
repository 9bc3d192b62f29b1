"""The nodes of a glTF: which mesh is placed where. They must form trees and have finite transforms."""

from __future__ import annotations

from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile

_PLACES = {"matrix": 16, "translation": 3, "rotation": 4, "scale": 3}


def placed_meshes(file: MeshFile, tree: dict[str, Any], count: int) -> list[tuple[int, Float64]]:
    """Return the meshes that a viewer shows, once per placement, each with its transform to the scene.

    Parameters
    ----------
    file : MeshFile
    tree : dict
        The JSON of the glTF; its first scene is used unless it names another.
    count : int
        Number of meshes.

    Returns
    -------
    list of (int, (4, 4) float64)
        Index of the mesh, and the matrix from its coordinates (as columns) to those of the scene.

    Raises
    ------
    InputError
        If a node is its own ancestor, has two parents, or has a transform that is not finite.
    IndexError, KeyError, TypeError, ValueError
        If the nodes are invalid in another way.
    """
    nodes = tree.get("nodes", [])
    if not nodes:  # without a scene graph all meshes are in place
        return [(mesh, np.eye(4)) for mesh in range(count)]
    placed: list[tuple[int, Float64]] = []
    seen: set[int] = set()
    waiting = [(root, np.eye(4)) for root in reversed(_roots(tree, nodes))]
    while waiting:
        index, above = waiting.pop()
        if index in seen:
            raise InputError(
                f"{file.path}: node {index} of the scene has two parents or is its own ancestor; export it again"
            )
        seen.add(index)
        node = nodes[index]
        with np.errstate(all="ignore"):
            matrix = above @ _matrix(node)
        if not np.isfinite(matrix).all():
            raise InputError(
                f"{file.path}: node {index} of the scene has a transform that is not finite; export it again"
            )
        if "mesh" in node:
            placed += [(mesh, matrix) for mesh in _indices([node["mesh"]], count)]
        waiting += [(child, matrix) for child in reversed(_indices(node.get("children", []), len(nodes)))]
    return placed


def _roots(tree: dict[str, Any], nodes: list[dict[str, Any]]) -> list[int]:
    if tree.get("scenes"):
        (scene,) = _indices([tree.get("scene", 0)], len(tree["scenes"]))
        return _indices(tree["scenes"][scene].get("nodes", []), len(nodes))
    below = {child for node in nodes for child in node.get("children", [])}
    return [i for i in range(len(nodes)) if i not in below]


def _indices(values: Any, count: int) -> list[int]:
    if not all(isinstance(v, int) and not isinstance(v, bool) and 0 <= v < count for v in values):
        raise IndexError
    return list(values)


def _matrix(node: dict[str, Any]) -> Float64:
    """The (4, 4) float64 matrix from a node to its parent: given, or made of scale, then rotation, then translation."""
    given = {key: _numbers(node[key], size) for key, size in _PLACES.items() if key in node}
    if "matrix" in given:
        return given["matrix"].reshape(4, 4).T  # stored by columns
    matrix = np.eye(4)
    if "rotation" in given:
        matrix[:3, :3] = _rotation(given["rotation"])
    matrix[:3, :3] *= given.get("scale", np.ones(3))
    matrix[:3, 3] = given.get("translation", np.zeros(3))
    return matrix


def _rotation(quaternion: Float64) -> Float64:
    length = np.sqrt((quaternion * quaternion).sum())
    if length == 0:  # no rotation
        return np.eye(3)
    x, y, z, w = quaternion / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _numbers(values: Any, count: int) -> Float64:
    if len(values) != count or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        raise TypeError
    return np.array(values, np.float64)

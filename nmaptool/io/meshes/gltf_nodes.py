"""The nodes of a glTF: which mesh is placed where. They must form trees and have finite transforms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.accessors import Accessors
from nmaptool.io.meshes.headers import MeshFile

_PLACES = {"matrix": 16, "translation": 3, "rotation": 4, "scale": 3}
_INSTANCING = "EXT_mesh_gpu_instancing"


@dataclass(frozen=True, eq=False)
class Placement:
    """A mesh of a glTF where a viewer shows it.

    Attributes
    ----------
    mesh : int
    matrices : (K, 4, 4) float64
        From its coordinates (as columns) to those of the scene, one for each instance.
    weights : list of float
        Weights of its morph targets.
    joints : (J, 4, 4) float64 or None
        The same for each joint of its skin; vertices that follow joints ignore ``matrices``.
    """

    mesh: int
    matrices: Float64
    weights: list[float]
    joints: Float64 | None


def placements(accessors: Accessors) -> tuple[list[Placement], int]:
    """Return the meshes that a viewer shows, and the number of meshes that are in no node of the scene.

    The first scene is shown unless the file names another. Without any nodes, all meshes are in place.

    Raises
    ------
    InputError
        If a node is its own ancestor, has two parents, or has a transform that is not finite.
    IndexError, KeyError, TypeError, ValueError
        If the nodes are invalid in another way.
    """
    tree = accessors.tree
    nodes, meshes = tree.get("nodes", []), tree.get("meshes", [])
    if not nodes:
        all_in_place = range(len(meshes))
        return [Placement(k, np.eye(4)[None], _weights({}, meshes[k]), None) for k in all_in_place], 0
    shown = _Walk(accessors.file, nodes)
    shown.walk(_roots(tree, nodes))
    everywhere: dict[int, Float64] | None = None
    placed: list[Placement] = []
    for index in list(shown.matrices):
        node = nodes[index]
        if "mesh" not in node:
            continue
        (mesh,) = _indices([node["mesh"]], len(meshes))
        joints = None
        if "skin" in node and _is_skinned(meshes[mesh]):
            if everywhere is None:
                everywhere = _all_matrices(shown, nodes)
            joints = _joints(accessors, node["skin"], everywhere)
        matrices = shown.matrices[index] @ _instances(accessors, node)
        _require_finite(accessors.file, index, matrices)
        placed.append(Placement(mesh, matrices, _weights(node, meshes[mesh]), joints))
    return placed, len(set(range(len(meshes))) - {each.mesh for each in placed})


class _Walk:
    """The matrices from nodes to the scene, in the order in which the nodes are drawn."""

    def __init__(self, file: MeshFile, nodes: list[dict[str, Any]]) -> None:
        self._file, self._nodes = file, nodes
        self.matrices: dict[int, Float64] = {}

    def walk(self, roots: list[int]) -> None:
        waiting = [(root, np.eye(4)) for root in reversed(roots)]
        while waiting:
            index, above = waiting.pop()
            if index in self.matrices:
                raise InputError(
                    f"{self._file.path}: node {index} of the scene has two parents or is its own ancestor; export it "
                    "again"
                )
            node = self._nodes[index]
            with np.errstate(all="ignore"):
                matrix = above @ _matrix(node)
            _require_finite(self._file, index, matrix)
            self.matrices[index] = matrix
            children = _indices(node.get("children", []), len(self._nodes))
            waiting += [(child, matrix) for child in reversed(children)]


def _all_matrices(shown: _Walk, nodes: list[dict[str, Any]]) -> dict[int, Float64]:
    """The matrices of all nodes, because joints may be outside the scene."""
    below = {child for node in nodes for child in node.get("children", [])}
    shown.walk([i for i in range(len(nodes)) if i not in below and i not in shown.matrices])
    return shown.matrices


def _require_finite(file: MeshFile, index: int, matrices: Float64) -> None:
    if not np.isfinite(matrices).all():
        raise InputError(f"{file.path}: node {index} of the scene has a transform that is not finite; export it again")


def _is_skinned(mesh: dict[str, Any]) -> bool:
    return any("JOINTS_0" in primitive["attributes"] for primitive in mesh["primitives"])


def _joints(accessors: Accessors, index: Any, matrices: dict[int, Float64]) -> Float64:
    """(J, 4, 4): from the mesh at rest to the scene, by each joint."""
    skin = accessors.item("skins", index)
    places = np.stack([matrices[joint] for joint in skin["joints"]])
    if "inverseBindMatrices" not in skin:
        return places
    stored = accessors.column(skin["inverseBindMatrices"], "MAT4", (5126,)).values()
    if len(stored) < len(places):
        raise ValueError
    inverse = stored[: len(places)].reshape(-1, 4, 4).transpose(0, 2, 1)  # stored by columns
    with np.errstate(all="ignore"):
        return np.asarray(places @ inverse)


def _instances(accessors: Accessors, node: dict[str, Any]) -> Float64:
    """(K, 4, 4): the matrices of the instances of a node; one that moves nothing if it has none."""
    extension = node.get("extensions", {}).get(_INSTANCING)
    attributes = {} if extension is None else extension.get("attributes", {})
    given = {
        name: accessors.column(attributes[name], shape).values()
        for name, shape in (("TRANSLATION", "VEC3"), ("ROTATION", "VEC4"), ("SCALE", "VEC3"))
        if name in attributes
    }
    if not given:
        return np.eye(4)[None]
    counts = {len(values) for values in given.values()}
    if len(counts) != 1:
        raise ValueError
    count = counts.pop()
    matrices = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in given:
        matrices[:, :3, :3] = _rotations(given["ROTATION"])
    if "SCALE" in given:
        matrices[:, :3, :3] *= given["SCALE"][:, None, :]
    if "TRANSLATION" in given:
        matrices[:, :3, 3] = given["TRANSLATION"]
    return matrices


def _weights(node: dict[str, Any], mesh: dict[str, Any]) -> list[float]:
    """Weights of the morph targets: of the node, otherwise of the mesh; those not given are 0."""
    given = node.get("weights", mesh.get("weights", []))
    if len(given) > 4096:
        raise ValueError
    weights = _numbers(given, len(given))
    if not np.isfinite(weights).all():
        raise ValueError
    return [float(weight) for weight in weights]


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
        matrix[:3, :3] = _rotations(given["rotation"][None])[0]
    matrix[:3, :3] *= given.get("scale", np.ones(3))
    matrix[:3, 3] = given.get("translation", np.zeros(3))
    return matrix


def _rotations(quaternions: Float64) -> Float64:
    """(K, 3, 3) matrices of quaternions x, y, z, w; one of length 0 does not rotate."""
    length = np.sqrt((quaternions * quaternions).sum(axis=1))
    unit = quaternions / np.where(length == 0, 1, length)[:, None]
    x, y, z, w = np.where((length == 0)[:, None], np.array([0.0, 0.0, 0.0, 1.0]), unit).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _numbers(values: Any, count: int) -> Float64:
    if len(values) != count or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        raise TypeError
    return np.array(values, np.float64)

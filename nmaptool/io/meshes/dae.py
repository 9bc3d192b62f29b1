"""Read DAE (COLLADA) with pycollada, which the extra ``collada`` installs; no file that it names is opened."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, NmaptoolError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers, fans
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.upright import turned_y_up

_DEFINITIONS = re.compile(rb"<!(?:DOCTYPE|ENTITY)\b", re.IGNORECASE)


def read_dae(file: MeshFile, max_faces: int) -> Surface:
    """Read a DAE: the meshes of its scene in place, with y up.

    Raises
    ------
    InputError
        If pycollada is not installed, or the file is damaged or has no triangles.
    LimitError
        If it has more than ``max_faces`` triangles; each placement of a part counts.
    """
    try:
        import collada
    except ImportError:
        raise InputError(
            f'{file.path}: reading DAE needs pycollada; pip install "nmaptool-relief[collada]", or export it as GLB, '
            "STL, OBJ or PLY"
        ) from None
    data = file.read_bytes()
    if _DEFINITIONS.search(data):
        raise file.damaged
    left_out = [collada.common.DaeUnsupportedError, collada.common.DaeBrokenRefError]
    try:
        document = collada.Collada(io.BytesIO(data), ignore=left_out)
        return _surface(file, document, max_faces)
    except (NmaptoolError, MemoryError):
        raise
    except Exception:  # noqa: BLE001 - pycollada raises many kinds of errors for damaged files
        raise file.damaged from None


def _surface(file: MeshFile, document: Any, max_faces: int) -> Surface:
    points, pieces, made = list[Float64](), list[Integers](), list[Integers]()
    count = faces = placements = 0
    notes = ["ignored skeletons: the mesh is read as it is bound to them"] if document.controllers else []
    if document.animations:
        notes.append("ignored animations: the mesh is read at rest")
    has_lines = False
    for primitive, matrix in _placed(document):
        placements += 1
        file.check_limit(placements, max_faces)
        sizes = _sizes(primitive)
        has_lines |= sizes is None
        if sizes is None or not len(sizes):
            continue
        corners = np.asarray(primitive.vertex_index).reshape(-1).astype(np.int64)
        vertices = np.asarray(primitive.vertex, np.float64)
        if len(corners) != sizes.sum():
            raise file.damaged
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
            raise file.names_missing_vertex(int(corners.max()), len(vertices))
        faces += int(np.maximum(sizes - 2, 0).sum())
        file.check_limit(faces, max_faces)
        used, corners = np.unique(corners, return_inverse=True)
        triangles = fans(sizes, corners.reshape(-1))
        if np.linalg.det(matrix[:3, :3]) < 0:  # mirroring turns a part inside out
            triangles = triangles[:, ::-1]
        points.append(vertices[used] @ matrix[:3, :3].T + matrix[:3, 3])
        pieces.append(triangles + count)
        made.append(np.maximum(sizes - 2, 0))
        count += len(used)
    if not faces:
        raise file.holds_no_faces(0)
    if has_lines:
        notes.append("ignored lines")
    asset = document.assetInfo
    turned = turned_y_up(np.concatenate(points), str(asset.upaxis or "Y_UP")[:1])
    unit = 1000.0 * float(asset.unitmeter or 1.0)
    return Surface(turned, np.concatenate(pieces), np.concatenate(made), tuple(notes), mm_per_unit=unit, is_y_up=True)


def _placed(document: Any) -> Iterator[tuple[Any, Float64]]:
    """The primitives of the scene with their matrices (4, 4); without a scene, all as they are."""
    if document.scene is None:
        for geometry in document.geometries:
            yield from ((primitive, np.eye(4)) for primitive in geometry.primitives)
        return
    for kind in ("geometry", "controller"):
        for bound in document.scene.objects(kind):
            geometry = bound if kind == "geometry" else getattr(bound, "geometry", None)
            if geometry is not None:
                matrix = np.asarray(geometry.matrix, np.float64)
                yield from ((primitive, matrix) for primitive in geometry.original.primitives)


def _sizes(primitive: Any) -> Integers | None:
    """Number of corners of each polygon; None for lines."""
    if "Line" in type(primitive).__name__:
        return None
    if primitive.vertex_index is None:
        return np.zeros(0, np.int64)
    if "Triangle" in type(primitive).__name__:
        return np.full(len(primitive.vertex_index), 3, np.int64)
    return np.asarray(primitive.vcounts).reshape(-1).astype(np.int64)

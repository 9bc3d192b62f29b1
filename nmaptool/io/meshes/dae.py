"""Read DAE (COLLADA) with pycollada, which the extra ``collada`` installs; no file that it names is opened."""

from __future__ import annotations

import io
import re
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
    try:
        document = collada.Collada(io.BytesIO(data), ignore=[collada.DaeUnsupportedError, collada.DaeBrokenRefError])
        return _surface(file, document, max_faces)
    except (NmaptoolError, MemoryError):
        raise
    except Exception:  # noqa: BLE001 - pycollada raises many kinds of errors for damaged files
        raise file.damaged from None


def _surface(file: MeshFile, document: Any, max_faces: int) -> Surface:
    points, pieces, made = list[Float64](), list[Integers](), list[Integers]()
    count = faces = 0
    notes = ["ignored skeletons: the mesh is read as it is bound to them"] if document.controllers else []
    if document.animations:
        notes.append("ignored animations: the mesh is read at rest")
    others = set[str]()
    for primitive in _primitives(document):
        if not hasattr(primitive, "vertex_index") or primitive.vertex_index is None:
            continue
        corners = np.asarray(primitive.vertex_index).reshape(-1).astype(np.int64)
        sizes = _sizes(primitive, len(corners))
        if sizes is None:
            others.add("lines")
            continue
        vertices = np.asarray(primitive.vertex, np.float64)
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
            raise file.names_missing_vertex(int(corners.max()), len(vertices))
        faces += int(np.maximum(sizes - 2, 0).sum())
        file.check_limit(faces, max_faces)
        used, corners = np.unique(corners, return_inverse=True)
        points.append(vertices[used])
        pieces.append(fans(sizes, corners.reshape(-1)) + count)
        made.append(np.maximum(sizes - 2, 0))
        count += len(used)
    if not faces:
        raise file.holds_no_faces(0)
    notes += [f"ignored {what}" for what in sorted(others)]
    asset = document.assetInfo
    vertices = turned_y_up(np.concatenate(points), str(asset.upaxis or "Y_UP")[:1])
    unit = 1000.0 * float(asset.unitmeter if asset.unitmeter is not None else 1.0)
    return Surface(vertices, np.concatenate(pieces), np.concatenate(made), tuple(notes), mm_per_unit=unit, is_y_up=True)


def _primitives(document: Any) -> Any:
    """The primitives of the scene with the transforms of their nodes applied; without a scene, all as they are."""
    if document.scene is None:
        for geometry in document.geometries:
            yield from geometry.primitives
        return
    for kind in ("geometry", "controller"):
        for placed in document.scene.objects(kind):
            yield from placed.primitives()


def _sizes(primitive: Any, corners: int) -> Integers | None:
    """Number of corners of each polygon; None for lines."""
    name = type(primitive).__name__
    if "Line" in name:
        return None
    if "Triangle" in name:
        return np.full(corners // 3, 3, np.int64)
    return np.asarray(primitive.vcounts).astype(np.int64)

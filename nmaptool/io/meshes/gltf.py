"""Read glTF and GLB: the triangles that a viewer shows at rest, with all transforms applied.

Images, materials and cameras are ignored, and the only other files that are opened are buffers in the same folder.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.accessors import Accessors
from nmaptool.io.meshes.gltf_buffers import COMPRESSED, Buffers, is_compressed
from nmaptool.io.meshes.gltf_nodes import Placement, placements
from nmaptool.io.meshes.gltf_parts import Part, moved, part_of
from nmaptool.io.meshes.headers import NAMES, MeshFile
from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.surface import Surface
from nmaptool.types.shown import counted

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_LEAST_BYTES = 20  # the header of a GLB file and that of its first chunk


def read_gltf(file: MeshFile, max_faces: int) -> Surface:
    """Read a glTF or GLB.

    Raises
    ------
    InputError
        If it is damaged or compressed, needs files that are missing or in other folders, or has no triangles.
    LimitError
        If it has more than ``max_faces`` triangles; each placement of a part counts.
    """
    tree, own = _container(file, file.read_bytes())
    _check_kind(file, tree)
    accessors = Accessors(file, tree, Buffers.of(file, tree.get("buffers", []), own))
    meshes, other = _meshes(accessors)
    placed, outside = placements(accessors)
    shown = [(part, place) for place in placed for part in meshes[place.mesh] if len(place.matrices)]
    if not shown:
        raise file.holds_no_faces(other.get("vertices", 0))
    _check_limits(file, shown, max_faces)
    pieces, triangles, count = [], [], 0
    for part, place in shown:
        points, faces = _arrays(file, part, place)
        pieces.append(points)
        triangles.append(faces + count)
        count += len(points)
    notes = _notes(tree, other, outside)
    vertices, corners = np.concatenate(pieces), np.concatenate(triangles)
    return Surface(vertices, corners, notes=notes, mm_per_unit=1000.0, is_y_up=True)


def _meshes(accessors: Accessors) -> tuple[list[list[Part]], dict[str, int]]:
    """The sets of triangles of each mesh, and how many sets of points and lines, and vertices in them, there are."""
    other = {"points": 0, "lines": 0, "vertices": 0}
    meshes = []
    for mesh in accessors.tree.get("meshes", []):
        parts = []
        for primitive in mesh["primitives"]:
            part = part_of(accessors, primitive)
            if isinstance(part, Part):
                parts += [part] if part.faces else []
            elif part:
                other[part] += 1
                other["vertices"] += accessors.count(primitive["attributes"]["POSITION"])
        meshes.append(parts)
    return meshes, other


def _notes(tree: dict[str, Any], other: dict[str, int], outside: int) -> tuple[str, ...]:
    """What was left out, one sentence each."""
    moving, scenes = len(tree.get("animations", [])), len(tree.get("scenes", []))
    notes = []
    if moving:
        notes.append(f"ignored {counted(moving, 'animation')}: the mesh is read at rest")
    notes += [f"ignored {counted(other[what], 'set')} of {what}" for what in ("points", "lines") if other[what]]
    if outside:
        scene = f"scene {tree.get('scene', 0)} of {scenes} is" if scenes > 1 else "the scene is"
        notes.append(f"{scene} read; ignored {counted(outside, 'mesh')} outside it")
    return tuple(notes)


def _arrays(file: MeshFile, part: Part, place: Placement) -> tuple[Float64, Integers]:
    """Return (N, 3) float64 positions in the scene and (M, 3) int64 triangles with checked indices."""
    faces = part.triangles()
    if faces.max() >= part.vertices:
        raise file.names_missing_vertex(int(faces.max()), part.vertices)
    points = part.points(place.weights)
    if part.joints and place.joints is not None:
        points, determinants = part.skinned(points, place.joints)
        mirrored = determinants[faces].sum(axis=1) < 0  # mirroring turns a part inside out
        return points, np.where(mirrored[:, None], faces[:, ::-1], faces)
    pieces = [moved(points, matrix) for matrix in place.matrices]
    turned = [faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces for matrix in place.matrices]
    triangles = [each + k * len(points) for k, each in enumerate(turned)]
    return np.concatenate(pieces), np.concatenate(triangles)


def _check_limits(file: MeshFile, shown: list[tuple[Part, Placement]], max_faces: int) -> None:
    file.check_limit(sum(part.faces * len(place.matrices) for part, place in shown), max_faces)
    # each placed part brings its whole array of vertices, used or not
    vertices = sum(part.vertices * len(place.matrices) for part, place in shown)
    if vertices > 3 * max_faces:
        raise LimitError(
            f"{file.path}: {vertices} vertices, more than the limit of {3 * max_faces} for {max_faces} faces; "
            "decimate it, or raise `max_faces`"
        )


def _container(file: MeshFile, data: bytes) -> tuple[dict[str, Any], bytes | None]:
    """Return the JSON of a file and the binary data after it, if there are any."""
    own = None
    if file.kind == "glb":
        version, length = struct.unpack_from("<II", data, 4) if len(data) >= 12 else (2, 0)
        if version != 2:
            raise _too_old(file)
        if len(data) < max(length, _LEAST_BYTES):
            held = f"it declares {length} bytes but holds {len(data)}"
            if length <= len(data):
                held = f"it holds {len(data)} bytes, but every GLB file has at least {_LEAST_BYTES}"
            raise InputError(f"{file.path}: the GLB file is truncated: {held}; export or download it again")
        chunks = list(_chunks(data[:length]))
        if chunks[0][0] != _JSON:
            raise file.damaged
        own = next((body for kind, body in chunks[1:2] if kind == _BIN), None)
        data = chunks[0][1]
    try:
        tree = json.loads(data.decode("utf-8-sig"))
    except json.JSONDecodeError as error:
        raise InputError(
            f"{file.path}: line {error.lineno} is not valid JSON: the {NAMES[file.kind]} file is truncated or damaged; "
            "export it again"
        ) from None
    if not isinstance(tree, dict):
        raise file.damaged
    return tree, own


def _too_old(file: MeshFile) -> InputError:
    return InputError(f"{file.path}: is not glTF version 2; export it as glTF 2.0")


def _chunks(data: bytes) -> list[tuple[int, bytes]]:
    chunks, offset = [], 12
    while offset + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, offset)
        offset += 8
        if offset + size > len(data):
            raise ValueError
        chunks.append((kind, data[offset : offset + size]))
        offset += size
    return chunks


def _check_kind(file: MeshFile, tree: dict[str, Any]) -> None:
    if "asset" not in tree:
        raise InputError(f"{file.path}: holds no {NAMES[file.kind]} data; export it again, preferably as one GLB file")
    if str(tree["asset"].get("version", "2.0")).partition(".")[0] != "2":
        raise _too_old(file)
    for name in COMPRESSED.keys() & set(tree.get("extensionsRequired", [])):
        if COMPRESSED[name] != "Draco":  # which may be installed
            raise is_compressed(file, COMPRESSED[name])

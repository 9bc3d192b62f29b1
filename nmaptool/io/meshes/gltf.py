"""Read glTF and GLB: the triangles that a viewer shows, with the transforms of the scene applied.

Images, materials, cameras and animations are ignored, and no link in the file is opened.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.accessors import Accessors, refuse_compressed, whole_number
from nmaptool.io.meshes.gltf_nodes import placed_meshes
from nmaptool.io.meshes.headers import NAMES, MeshFile
from nmaptool.io.meshes.polygons import Integers, one_strip
from nmaptool.io.meshes.surface import Surface

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_LEAST_BYTES = 20  # the header of a GLB file and that of its first chunk
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read_gltf(file: MeshFile, max_faces: int) -> Surface:
    """Read a glTF or GLB.

    Raises
    ------
    InputError
        If it is damaged or compressed, needs other files, or has no triangles.
    LimitError
        If it has more than ``max_faces`` triangles; each placement of a part counts.
    """
    tree, own = _container(file, file.path.read_bytes())
    _check_kind(file, tree)
    buffers = [_buffer(file, buffer, own if i == 0 else None) for i, buffer in enumerate(tree.get("buffers", []))]
    parts = _placed(file, Accessors(file, tree, buffers))
    _check_limits(file, [part for part, _ in parts], max_faces)
    vertices, triangles, count = [], [], 0
    for part, matrix in parts:
        points, faces = part.arrays(file)
        faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces  # mirroring turns a part inside out
        vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
        triangles.append(faces + count)
        count += len(points)
    return Surface(np.concatenate(vertices), np.concatenate(triangles))


@dataclass(frozen=True)
class _Part:
    """One set of triangles: its positions, its corner indices if it has any, and whether it is a strip."""

    positions: NDArray[Any]
    indices: NDArray[Any] | None
    is_strip: bool

    @property
    def corners(self) -> int:
        """Number of corners."""
        return len(self.positions if self.indices is None else self.indices)

    @property
    def faces(self) -> int:
        """Number of triangles."""
        return max(self.corners - 2, 0) if self.is_strip else self.corners // 3

    def arrays(self, file: MeshFile) -> tuple[Float64, Integers]:
        """Return (N, 3) float64 positions and (M, 3) int64 triangles with checked indices."""
        count = len(self.positions)
        corners = np.arange(count) if self.indices is None else self.indices.astype(np.int64)
        if corners.max() >= count:
            raise file.names_missing_vertex(int(corners.max()), count)
        return self.positions.astype(np.float64), one_strip(corners) if self.is_strip else corners.reshape(-1, 3)


def _placed(file: MeshFile, accessors: Accessors) -> list[tuple[_Part, Float64]]:
    """Return each set of triangles with its transform to the scene, once per placement."""
    points = 0
    meshes = []
    for mesh in accessors.tree.get("meshes", []):
        parts = [_part(file, accessors, primitive) for primitive in mesh["primitives"]]
        points += sum(part for part in parts if isinstance(part, int))
        meshes.append([part for part in parts if isinstance(part, _Part) and part.faces])
    shown = placed_meshes(file, accessors.tree, len(meshes))
    placed = [(part, matrix) for i, matrix in shown for part in meshes[i]]
    if not placed:
        raise file.holds_no_faces(points)
    return placed


def _part(file: MeshFile, accessors: Accessors, primitive: dict[str, Any]) -> _Part | int:
    """Return a set of triangles, or the number of points if there are only points or lines."""
    mode = whole_number(primitive.get("mode", _TRIANGLES))
    position, indices = primitive["attributes"].get("POSITION"), primitive.get("indices")
    if position is None:
        return 0
    if mode < _TRIANGLES:
        return whole_number(accessors.item("accessors", position)["count"])
    if mode == _FAN:
        raise InputError(f"{file.path}: holds triangle fans; export it again as plain triangles")
    positions = accessors.positions(position)
    given = None if indices is None or not len(positions) else accessors.indices(indices)
    part = _Part(positions, given, mode == _STRIP)
    if mode > _FAN or (mode == _TRIANGLES and part.corners % 3):
        raise ValueError
    return part


def _check_limits(file: MeshFile, parts: list[_Part], max_faces: int) -> None:
    file.check_limit(sum(part.faces for part in parts), max_faces)
    # each placed part brings its whole array of vertices, used or not
    vertices = sum(len(part.positions) for part in parts)
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
    tree = json.loads(data.decode("utf-8-sig"))
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
    refuse_compressed(file, tree.get("extensionsRequired", []))
    if any("EXT_mesh_gpu_instancing" in node.get("extensions", {}) for node in tree.get("nodes", [])):
        raise InputError(f"{file.path}: uses GPU instancing; make the instances real and export it again")


def _buffer(file: MeshFile, buffer: dict[str, Any], own: bytes | None) -> bytes:
    """Return the bytes of a buffer: ``own``, the binary data of the GLB, or those in a ``data:`` URI."""
    uri = buffer.get("uri")
    if uri is None:
        if own is None:
            refuse_compressed(file, buffer.get("extensions", {}))
            raise file.damaged
        data = own
    elif isinstance(uri, str) and uri[:5].lower() == "data:":
        head, _, text = uri.partition(",")
        if not head.endswith(";base64"):
            raise file.damaged
        try:
            data = base64.b64decode(text, validate=True)
        except binascii.Error:
            raise file.damaged from None
    else:
        raise InputError(f"{file.path}: stores data in other files, which are not opened; export it as one GLB file")
    if len(data) < whole_number(buffer["byteLength"]):
        raise file.damaged
    return data

"""glTF and GLB reduced to positions, triangles and places, so that nothing else of them reaches trimesh.

What is handed on is written anew from what was understood: no image, material, camera, animation or address is in it.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Iterable
from itertools import accumulate
from typing import Any

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.gltf_nodes import placed_meshes
from nmaptool.io.meshes.headers import NAMES, MeshFile

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_ITEM_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_INDEX_TYPES = (5121, 5123, 5125)
_TRIANGLES, _FAN = 4, 6
_FLOAT = 5126
_LARGEST_STRIDE = 252
_COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}


def plain_glb(file: MeshFile, data: bytes, max_faces: int) -> bytes:
    """A GLB of the triangles and nodes of a glTF or GLB, and of nothing else.

    Raises
    ------
    InputError
        If it is damaged, compressed, or needs other files.
    LimitError
        If its triangles, counted as often as they are placed, are more than ``max_faces``.
    """
    try:
        tree, own = _container(file, data)
        _check_kind(file, tree)
        buffers = [_buffer(file, buffer, own if i == 0 else None) for i, buffer in enumerate(tree.get("buffers", []))]
        return _Surface(file, tree, buffers).written(max_faces)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise file.damaged from None


def _container(file: MeshFile, data: bytes) -> tuple[dict[str, Any], bytes | None]:
    """The JSON of a file and the binary data that follow it."""
    own = None
    if file.kind == "glb":
        version, length = struct.unpack_from("<II", data, 4) if len(data) >= 12 else (2, 12)
        if version != 2:
            raise _too_old(file)
        if len(data) < max(length, 20):
            raise InputError(
                f"{file.path}: the GLB file is cut short: it announces {length} bytes and holds {len(data)}; "
                "export or download it again"
            )
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
    return InputError(f"{file.path}: is not of glTF version 2; export it as glTF 2.0")


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
        raise InputError(f"{file.path}: holds no {NAMES[file.kind]} data; export it again, best as one GLB file")
    if str(tree["asset"].get("version", "2.0")).partition(".")[0] != "2":
        raise _too_old(file)
    _refuse_compressed(file, tree.get("extensionsRequired", []))
    if any("EXT_mesh_gpu_instancing" in node.get("extensions", {}) for node in tree.get("nodes", [])):
        raise InputError(f"{file.path}: repeats parts by instancing; export it again with the instances made real")


def _refuse_compressed(file: MeshFile, extensions: Iterable[Any]) -> None:
    for name in _COMPRESSED.keys() & set(extensions):
        raise InputError(f"{file.path}: is compressed with {_COMPRESSED[name]}; export it again without compression")


def _buffer(file: MeshFile, buffer: dict[str, Any], own: bytes | None) -> bytes:
    """The bytes of a buffer: of the GLB itself or written into an address that begins with ``data:``."""
    uri = buffer.get("uri")
    if uri is None:
        if own is None:
            _refuse_compressed(file, buffer.get("extensions", {}))
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
        raise InputError(f"{file.path}: keeps its data in other files, which are not opened; export it as one GLB file")
    if len(data) < _count(buffer["byteLength"]):
        raise file.damaged
    return data


def _count(value: Any) -> int:
    """A whole number of zero or more."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError
    return value


class _Surface:
    """Collects what is handed on: the accessors that triangles use, each once."""

    def __init__(self, file: MeshFile, tree: dict[str, Any], buffers: list[bytes]) -> None:
        self.file, self.tree = file, tree
        self.starts = list(accumulate((len(buffer) for buffer in buffers), initial=0))
        self.binary = b"".join(buffers)
        self.accessors: dict[int, int] = {}
        self.points = 0

    def written(self, max_faces: int) -> bytes:
        """The whole as a GLB.

        Raises
        ------
        InputError
            If there are no triangles.
        LimitError
        """
        pieces = [self._primitives(mesh) for mesh in self.tree.get("meshes", [])]
        # trimesh would lose what stands at a node of a mesh without primitives
        shown = [(i, matrix) for i, matrix in placed_meshes(self.file, self.tree, len(pieces)) if pieces[i]]
        placed = [primitive for i, _ in shown for primitive in pieces[i]]
        if not placed:
            raise self.file.holds_no_faces(self.points)
        self.file.check_limit(sum(faces for faces, _ in placed), max_faces)
        # vertices that faces share are there once for each set of faces, used or not
        extents = [self._extent(index) for index in self.accessors]
        vertices = sum(extents[primitive["attributes"]["POSITION"]][1]["count"] for _, primitive in placed)
        if vertices > 3 * max_faces:
            raise LimitError(
                f"{self.file.path}: {vertices} vertices, more than the limit of {3 * max_faces} for {max_faces} faces; "
                "decimate it, or raise --max-faces"
            )
        plain = {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": len(self.binary)}],
            "bufferViews": [{"buffer": 0, **view} for view, _ in extents],
            "accessors": [{"bufferView": i, **accessor} for i, (_, accessor) in enumerate(extents)],
            "meshes": [{"primitives": [primitive for _, primitive in piece]} for piece in pieces],
            "nodes": [{"mesh": i, "matrix": matrix.T.reshape(-1).tolist()} for i, matrix in shown],
            "scenes": [{"nodes": list(range(len(shown)))[::-1]}],  # trimesh begins with the last
            "scene": 0,
        }
        text = json.dumps(plain).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.binary)
        if size > 0xFFFFFFFF:
            raise MemoryError  # more than a GLB can hold
        head = struct.pack("<4sIIII", b"glTF", 2, size, len(text), _JSON)
        return b"".join((head, text, struct.pack("<II", len(self.binary), _BIN), self.binary))

    def _primitives(self, mesh: dict[str, Any]) -> list[tuple[int, dict[str, Any]]]:
        """Each set of triangles of a mesh, behind their number; points and lines are left out."""
        found = []
        for primitive in mesh["primitives"]:
            mode = _count(primitive.get("mode", _TRIANGLES))
            position, indices = primitive["attributes"].get("POSITION"), primitive.get("indices")
            if position is None:
                continue
            if mode < _TRIANGLES:
                self.points += _count(self._item("accessors", position)["count"])
                continue
            if mode == _FAN:
                raise InputError(f"{self.file.path}: holds triangle fans; export it again as plain triangles")
            corners = self._check(position, "VEC3", tuple(_ITEM_BYTES))
            if indices is not None:
                corners = self._check(indices, "SCALAR", _INDEX_TYPES) if corners else 0
            if mode > _FAN or (mode == _TRIANGLES and corners % 3):
                raise ValueError
            faces = corners // 3 if mode == _TRIANGLES else max(corners - 2, 0)
            if faces:
                plain: dict[str, Any] = {"attributes": {"POSITION": self._number(position)}, "mode": mode}
                found.append((faces, plain if indices is None else {**plain, "indices": self._number(indices)}))
        return found

    def _number(self, index: int) -> int:
        return self.accessors.setdefault(index, len(self.accessors))

    def _item(self, what: str, index: Any) -> dict[str, Any]:
        item = self.tree[what][_count(index)]
        if not isinstance(item, dict):
            raise TypeError
        return item

    def _check(self, index: Any, shape: str, types: tuple[int, ...]) -> int:
        """Number of items in an accessor of the right kind, whose bytes are all there."""
        accessor = self._item("accessors", index)
        kind = accessor["componentType"]
        if accessor["type"] != shape or kind not in types:
            raise ValueError
        if "sparse" in accessor or (accessor.get("normalized") and kind != _FLOAT):
            raise InputError(
                f"{self.file.path}: stores positions in a reduced form (sparse or quantised); "
                "export it again without compression"
            )
        self._extent(index)
        return _count(accessor["count"])

    def _extent(self, index: int) -> tuple[dict[str, int], dict[str, Any]]:
        """Where an accessor's bytes are among those of all buffers, as a view of its own, and what they mean."""
        accessor = self._item("accessors", index)
        if "bufferView" not in accessor:
            _refuse_compressed(self.file, self.tree.get("extensionsUsed", []))
        view = self._item("bufferViews", accessor["bufferView"])
        count, kind = _count(accessor["count"]), accessor["componentType"]
        item = _ITEM_BYTES[kind] * (3 if accessor["type"] == "VEC3" else 1)
        stride = _count(view.get("byteStride", item))
        offset, start = _count(accessor.get("byteOffset", 0)), _count(view.get("byteOffset", 0))
        length = (count - 1) * stride + item if count else 0
        buffer = _count(view["buffer"])
        size = self.starts[buffer + 1] - self.starts[buffer]
        inside = offset + length <= _count(view["byteLength"]) <= size - start
        if not (inside and item <= stride <= _LARGEST_STRIDE):
            raise ValueError
        plain = {"byteOffset": self.starts[buffer] + start + offset, "byteLength": length}
        if stride != item:
            plain["byteStride"] = stride
        return plain, {"componentType": kind, "count": count, "type": accessor["type"]}

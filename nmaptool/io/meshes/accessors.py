"""Accessors of a glTF: typed arrays in its buffers, checked against the sizes of the buffers before use."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_INDEX_TYPES = (5121, 5123, 5125)
_FLOAT = 5126
_LARGEST_STRIDE = 252
_COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}


def refuse_compressed(file: MeshFile, extensions: Iterable[Any]) -> None:
    """Refuse a file that uses an extension for compressed meshes.

    Raises
    ------
    InputError
    """
    for name in _COMPRESSED.keys() & set(extensions):
        raise InputError(f"{file.path}: is compressed with {_COMPRESSED[name]}; export it again without compression")


def whole_number(value: Any) -> int:
    """Return the value if it is a whole number of at least 0.

    Raises
    ------
    ValueError
        If the value is anything else.
    """
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError
    return value


@dataclass(frozen=True)
class Accessors:
    """The accessors of a glTF with the JSON ``tree`` and ``buffers`` of at least the declared lengths."""

    file: MeshFile
    tree: dict[str, Any]
    buffers: list[bytes]

    def item(self, what: str, index: Any) -> dict[str, Any]:
        """Return entry ``index`` of the list ``what`` in the JSON."""
        item = self.tree[what][whole_number(index)]
        if not isinstance(item, dict):
            raise TypeError
        return item

    def positions(self, index: Any) -> NDArray[Any]:
        """Return an (N, 3) view of positions of any component type.

        Raises
        ------
        InputError
            If they are sparse, quantised or compressed.
        """
        return self._view(index, "VEC3", tuple(_TYPES))

    def indices(self, index: Any) -> NDArray[Any]:
        """Return an (N,) view of unsigned integers; raises the same errors as `positions`."""
        return self._view(index, "SCALAR", _INDEX_TYPES).reshape(-1)

    def _view(self, index: Any, shape: str, types: tuple[int, ...]) -> NDArray[Any]:
        accessor = self.item("accessors", index)
        kind = accessor["componentType"]
        if accessor["type"] != shape or kind not in types:
            raise ValueError
        if "sparse" in accessor or (accessor.get("normalized") and kind != _FLOAT):
            raise InputError(
                f"{self.file.path}: stores sparse or quantised positions or indices; "
                "export it again without compression"
            )
        if "bufferView" not in accessor:
            refuse_compressed(self.file, self.tree.get("extensionsUsed", []))
        view = self.item("bufferViews", accessor["bufferView"])
        dtype, width = np.dtype(_TYPES[kind]), 3 if shape == "VEC3" else 1
        row = dtype.itemsize * width
        count, stride = whole_number(accessor["count"]), whole_number(view.get("byteStride", row))
        offset, start = whole_number(accessor.get("byteOffset", 0)), whole_number(view.get("byteOffset", 0))
        length = (count - 1) * stride + row if count else 0
        buffer = self.buffers[whole_number(view["buffer"])]
        inside = offset + length <= whole_number(view["byteLength"]) <= len(buffer) - start
        if not (inside and row <= stride <= _LARGEST_STRIDE):
            raise ValueError
        return np.ndarray((count, width), dtype, buffer, start + offset, (stride, dtype.itemsize))

"""Accessors of a glTF: typed arrays in its buffers, checked against the sizes of the buffers before use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.gltf_buffers import COMPRESSED, Buffers, is_compressed, whole_number
from nmaptool.io.meshes.headers import MeshFile

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
ANY_TYPES = tuple(_TYPES)
INDEX_TYPES = (5121, 5123, 5125)
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_LARGEST_STRIDE = 252


@dataclass(frozen=True, eq=False)
class Column:
    """An accessor whose bounds have been checked; its values are read on demand.

    Attributes
    ----------
    count, width : int
        Rows, and values in each.
    dense : (N, W) or None
        A view of its buffer; None if all values are 0.
    places, changed : (S,) integers and (S, W), or None
        Rows of a sparse accessor that differ, and their values.
    is_normalized : bool
        Whether integers stand for 0 to 1, or for -1 to 1 if they are signed.
    dtype : dtype
    """

    count: int
    width: int
    dense: NDArray[Any] | None
    places: NDArray[Any] | None
    changed: NDArray[Any] | None
    is_normalized: bool
    dtype: np.dtype[Any]

    def stored(self) -> NDArray[Any]:
        """(N, W): the values as stored.

        Raises
        ------
        IndexError
            If a sparse accessor changes a row that does not exist.
        """
        if self.dense is None:
            values = np.zeros((self.count, self.width), self.dtype)
        elif self.places is None:
            return self.dense
        else:
            values = self.dense.copy()
        if self.places is not None:
            values[self.places[:, 0].astype(np.int64)] = self.changed
        return values

    def values(self) -> Float64:
        """(N, W) float64: the values, with normalised integers as fractions."""
        return normalised(self.stored(), self.is_normalized)


def normalised(stored: NDArray[Any], is_normalized: bool) -> Float64:
    """The values as float64; normalised integers become -1 or 0 to 1."""
    values = stored.astype(np.float64)
    if is_normalized and stored.dtype.kind in "iu":
        values /= np.iinfo(stored.dtype).max
        np.maximum(values, -1.0, out=values)
    return values


@dataclass(frozen=True)
class Accessors:
    """The accessors of a glTF with the JSON ``tree`` and ``buffers`` of at least the declared lengths."""

    file: MeshFile
    tree: dict[str, Any]
    buffers: Buffers

    def item(self, what: str, index: Any) -> dict[str, Any]:
        """Return entry ``index`` of the list ``what`` in the JSON."""
        item = self.tree[what][whole_number(index)]
        if not isinstance(item, dict):
            raise TypeError
        return item

    def count(self, index: Any) -> int:
        """Rows that an accessor declares."""
        return whole_number(self.item("accessors", index)["count"])

    def column(self, index: Any, shape: str, types: tuple[int, ...] = ANY_TYPES) -> Column:
        """Check an accessor of a shape, such as ``VEC3``, and of one of the given component types.

        Raises
        ------
        InputError
            If it is compressed, or has no data.
        IndexError, KeyError, TypeError, ValueError
            If it is invalid in another way.
        """
        accessor = self.item("accessors", index)
        kind, count = accessor["componentType"], whole_number(accessor["count"])
        if accessor["type"] != shape or kind not in types:
            raise ValueError
        sparse = accessor.get("sparse")
        dense = places = changed = None
        if "bufferView" in accessor:
            dense = self._view(accessor, kind, count, shape)
        elif count > self.buffers.total:  # zeros need no data, so a small file could declare any number of them
            raise self._without_data()
        if sparse is not None:
            few = whole_number(sparse["count"])
            index_kind = sparse["indices"]["componentType"]
            if few > count or index_kind not in INDEX_TYPES:
                raise ValueError
            places = self._view(sparse["indices"], index_kind, few, "SCALAR")
            changed = self._view(sparse["values"], kind, few, shape)
        dtype = np.dtype(_TYPES[kind])
        return Column(count, _WIDTHS[shape], dense, places, changed, bool(accessor.get("normalized")), dtype)

    def bytes_of(self, index: Any) -> bytes:
        """The bytes of a buffer view."""
        view = self.item("bufferViews", index)
        start, length = whole_number(view.get("byteOffset", 0)), whole_number(view["byteLength"])
        buffer = whole_number(view["buffer"])
        if start + length > self.buffers.sizes[buffer]:
            raise ValueError
        return self.buffers[buffer][start : start + length]

    def _without_data(self) -> InputError:
        for name in COMPRESSED.keys() & set(self.tree.get("extensionsUsed", [])):
            return is_compressed(self.file, COMPRESSED[name])
        return self.file.damaged

    def _view(self, place: dict[str, Any], kind: int, count: int, shape: str) -> NDArray[Any]:
        """A (count, W) view of the values at ``place``, an accessor or a part of a sparse one."""
        view = self.item("bufferViews", place["bufferView"])
        dtype, width = np.dtype(_TYPES[kind]), _WIDTHS[shape]
        row = dtype.itemsize * width
        stride = whole_number(view.get("byteStride", row))
        offset, start = whole_number(place.get("byteOffset", 0)), whole_number(view.get("byteOffset", 0))
        length = (count - 1) * stride + row if count else 0
        buffer = whole_number(view["buffer"])
        inside = offset + length <= whole_number(view["byteLength"]) <= self.buffers.sizes[buffer] - start
        if not (inside and row <= stride <= _LARGEST_STRIDE):
            raise ValueError
        return np.ndarray((count, width), dtype, self.buffers[buffer], start + offset, (stride, dtype.itemsize))

"""Find chunks that a Zarr array does not store: reading replaces them by the fill value without a word."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# the place in a shard's index of a chunk that is not stored
_NOWHERE = np.iinfo(np.uint64).max


class AbsentChunks:
    """The chunks of an array that are not stored.

    Parameters
    ----------
    array : zarr.Array
    """

    def __init__(self, array: Any) -> None:
        self._array = array
        self._fill = np.asarray(array.fill_value if array.fill_value is not None else 0, array.dtype)
        self._present: set[tuple[int, ...]] = set()

    def may_be(self, values: NDArray[Any]) -> bool:
        """Whether values read from one chunk are all the fill value, so that the chunk may be absent."""
        if not self._is_fill(values[:1, :1]):
            return False
        return self._is_fill(values)

    def _is_fill(self, values: NDArray[Any]) -> bool:
        same = values == self._fill
        if values.dtype.kind == "f" and np.isnan(self._fill):
            same = np.isnan(values)
        return bool(same.all())

    def key_of(self, block: tuple[int, int], axes: tuple[int, int, int | None]) -> str:
        """The key of a shard, or of a chunk without shards, such as c/3/0/0; the first among the channels."""
        at = [0] * len(self._array.shape)
        at[axes[0]], at[axes[1]] = block
        return str(self._array.metadata.encode_chunk_key(tuple(at)))

    def missing(self, block: tuple[int, int], layer: int, axes: tuple[int, int, int | None]) -> str | None:
        """The key of the chunk at a place if it is not stored, or that of its shard; None if it is there.

        Parameters
        ----------
        block : (int, int)
            Row and column in the grid of chunks; in the grid of inner chunks if there are shards.
        layer : int
            The place among the chunks of the channels.
        axes : (int, int, int or None)
            The places of rows, columns and channels among the axes of the array.
        """
        array = self._array
        at = [0] * len(array.shape)
        at[axes[0]], at[axes[1]] = block
        if axes[2] is not None:
            at[axes[2]] = layer
        if tuple(at) in self._present:
            return None
        chunks, shards = array.chunks, array.shards
        shard = at if shards is None else [a * c // s for a, c, s in zip(at, chunks, shards, strict=True)]
        key = str(array.metadata.encode_chunk_key(tuple(shard)))
        if not self._exists(key):
            return key
        if shards is not None:
            inner = tuple(a % (s // c) for a, c, s in zip(at, chunks, shards, strict=True))
            if self._is_nowhere(key, inner):
                return f"{'/'.join(map(str, inner))} of {key}"
        self._present.add(tuple(at))
        return None

    def _exists(self, key: str) -> bool:
        from zarr.core.sync import sync

        return bool(sync((self._array.store_path / key).exists()))

    def _is_nowhere(self, key: str, inner: tuple[int, ...]) -> bool:
        """Whether the index of a shard says that one of its chunks is not stored."""
        index = self._index(key)
        return index is not None and bool(index[inner] == _NOWHERE)

    def _index(self, key: str) -> NDArray[np.uint64] | None:
        """The offsets of the chunks in a shard; None if the index is packed in an unusual way."""
        from zarr.abc.store import RangeByteRequest, SuffixByteRequest
        from zarr.core.buffer import default_buffer_prototype
        from zarr.core.sync import sync

        codec = self._array.metadata.codecs[0].to_dict()["configuration"]
        names = [one["name"] for one in codec["index_codecs"]]
        if names not in (["bytes"], ["bytes", "crc32c"]):
            return None
        grid = tuple(s // c for s, c in zip(self._array.shards, self._array.chunks, strict=True))
        size = 16 * int(np.prod(grid))
        at_end = str(codec.get("index_location", "end")).endswith("end")
        sum_bytes = 4 * (len(names) - 1)
        wanted = SuffixByteRequest(size + sum_bytes) if at_end else RangeByteRequest(0, size + sum_bytes)
        data = sync((self._array.store_path / key).get(default_buffer_prototype(), wanted))
        if data is None or len(data) < size:  # Zarr takes an empty file for a shard without chunks
            return np.full(grid, _NOWHERE)
        entries = np.frombuffer(data.to_bytes()[:size], "<u8").reshape(*grid, 2)
        return entries[..., 0]

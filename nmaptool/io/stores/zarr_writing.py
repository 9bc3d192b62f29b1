"""Create Zarr arrays of pictures, and write them by windows."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nmaptool.core.errors import InputError, OutputError, UsageError, reason_of
from nmaptool.io.output.targets import exists_already
from nmaptool.io.stores.extra import fsspec_module, zarr_module
from nmaptool.io.stores.names import ZARR_FILES, local_path, split_name
from nmaptool.io.stores.windows import bounds
from nmaptool.io.stores.zarr_nodes import OWN, location_of

CHUNK, INNER = 2048, 512
_LEVEL = 3
# Blosc sorts the bytes of elements of at most this size
_MOST_SORTED = 255


class ZarrWriter:
    """A Zarr array that is written by windows; see `nmaptool.types.windows.WritableStore`.

    Parameters
    ----------
    name : str
        As given to `create_picture`.
    array : zarr.Array
    """

    def __init__(self, name: str, array: Any) -> None:
        self.name = name
        self._array = array
        self.rows, self.cols = (int(side) for side in array.shape[:2])
        unit = array.shards or array.chunks
        self.chunk = (int(unit[0]), int(unit[1]))
        self.dtype = np.dtype(array.dtype)

    def __reduce__(self) -> tuple[Any, ...]:
        return open_writable, (self.name,)

    def write(self, row: int, col: int, values: NDArray[Any]) -> None:
        """Write an (h, w) or (h, w, C) window at a row and a column.

        Whole chunks may be written by several processes at once; a part of a chunk is read, changed and written again.

        Raises
        ------
        UsageError
            If the window does not lie in the picture, or has other channels or another type.
        OutputError
            If it cannot be written.
        """
        rows, cols = slice(row, row + values.shape[0]), slice(col, col + values.shape[1])
        bounds(self.name, rows, cols, (self.rows, self.cols))
        own = self._array.shape[2:]
        values = values[..., 0] if not own and values.ndim == 3 and values.shape[2] == 1 else values
        if values.shape[2:] != own or values.dtype != self.dtype:
            raise UsageError(
                f"{self.name}: is written as {self.dtype} with {own[0] if own else 1} channels, found {values.dtype} "
                f"{values.shape}"
            )
        try:
            self._array[rows, cols] = values
        except OSError as error:
            raise OutputError(f"{self.name}: cannot be written ({reason_of(error)})") from None

    def add_attributes(self, attributes: Mapping[str, Any]) -> None:
        """Add metadata, as in `nmaptool.RasterImage`.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        try:
            self._array.update_attributes({OWN: {**dict(self._array.attrs.get(OWN, {})), **attributes}})
        except OSError as error:
            raise OutputError(f"{self.name}: cannot be written ({reason_of(error)})") from None


def create_picture(
    name: str,
    rows: int,
    cols: int,
    channels: tuple[str, ...],
    dtype: DTypeLike,
    *,
    chunk: int = CHUNK,
    inner: int = INNER,
    pitch_mm: float | None = None,
    attributes: Mapping[str, Any] | None = None,
    overwrite: bool = False,
) -> ZarrWriter:
    """Create a Zarr v3 array for a picture, to be written by windows.

    Parameters
    ----------
    name : str
        Path or URL; for an array of a group, ``group.zarr:array``.
    rows, cols : int
    channels : tuple of str
        With one channel, the array is (H, W), otherwise (H, W, C).
    dtype : dtype
    chunk : int
        Rows and columns of a shard, which is one file. A smaller picture is one shard.
    inner : int
        Rows and columns that are packed, and read, on their own; ``chunk`` is a multiple of it.
    pitch_mm : float, optional
    attributes : mapping, optional
        As in `nmaptool.RasterImage`; with ``absent_chunks`` "fill", chunks need not be written: they hold 0.
    overwrite : bool
        Replace a Zarr store that exists.

    Returns
    -------
    WritableStore

    Raises
    ------
    UsageError
        If ``chunk`` is not a multiple of ``inner``.
    OutputError
        If it exists or cannot be written.
    InputError
        If the extra is not installed.
    """
    zarr = zarr_module(name)
    if inner < 1 or chunk % inner:
        raise UsageError(f"`chunk={chunk}`: must be a multiple of the inner chunk of {inner} px")
    place, layer = split_name(name)
    if layer is None:
        make_room(place, overwrite)
    own = {"channels": list(channels), **dict(attributes or {})}
    if pitch_mm is not None:
        own["pitch_mm"] = pitch_mm
    many = len(channels) > 1
    shape = (rows, cols, len(channels)) if many else (rows, cols)
    whole = min(chunk, -(-max(rows, cols) // inner) * inner)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a NaN among the attributes, which other programs may not read
            array = zarr.create_array(
                location_of(place),
                name=layer,
                shape=shape,
                dtype=dtype,
                chunks=(inner, inner, *shape[2:]),
                shards=(whole, whole, *shape[2:]),
                compressors=_compressors(np.dtype(dtype), len(channels)),
                fill_value=0,
                dimension_names=("y", "x", "c")[: len(shape)],
                attributes={OWN: own},
                overwrite=overwrite,
                config={"write_empty_chunks": True},
            )
    except zarr.errors.ContainsArrayError:
        raise exists_already(Path(name)) from None
    except (ImportError, ValueError) as error:
        raise OutputError(f"{name}: cannot be created ({' '.join(str(error).split())})") from None
    except OSError as error:
        raise OutputError(f"{name}: cannot be created ({reason_of(error)})") from None
    return ZarrWriter(name, array)


def open_writable(name: str) -> ZarrWriter:
    """Open an array that `create_picture` made, such as in another process.

    Raises
    ------
    InputError
        If it does not exist.
    """
    zarr = zarr_module(name)
    place, layer = split_name(name)
    try:
        # zarr.open_array ignores its argument config for arrays that exist
        with zarr.config.set({"array.write_empty_chunks": True}):
            array = zarr.open_array(location_of(place), path=layer, mode="r+")
    except (OSError, zarr.errors.NodeNotFoundError):
        raise InputError(f"{name}: no such Zarr array; create it first") from None
    return ZarrWriter(name, array)


def _compressors(dtype: np.dtype[Any], channels: int) -> list[Any]:
    """Zstandard, after sorting the bytes by channel and place in the number, and a checksum, which Blosc lacks."""
    from zarr.codecs import BloscCodec, Crc32cCodec

    size = min(_MOST_SORTED, dtype.itemsize * channels)
    return [BloscCodec(cname="zstd", clevel=_LEVEL, shuffle="shuffle", typesize=size), Crc32cCodec()]


def make_room(place: str, overwrite: bool, *, remove: bool = True) -> None:
    """Refuse a place where something is that must not be replaced, and remove a Zarr store that may be.

    Parameters
    ----------
    place : str
    overwrite : bool
    remove : bool
        False to check only.

    Raises
    ------
    OutputError
    """
    path = local_path(place)
    if path is None:
        files, root = fsspec_module(place).core.url_to_fs(place)
        if files.exists(root):
            if not overwrite:
                raise OutputError(f"{place}: already exists; give another name, or `overwrite`")
            if remove:
                files.rm(root, recursive=True)
        return
    if not path.parent.is_dir():
        raise OutputError(f"{place}: the folder {path.parent} does not exist; create it first")
    if not path.exists():
        return
    if not overwrite:
        raise exists_already(path)
    if not path.is_dir() or not any((path / name).is_file() for name in ZARR_FILES):
        raise OutputError(f"{place}: is not a Zarr store, so it is not replaced; give another name")
    if not remove:
        return
    try:
        shutil.rmtree(path)
    except OSError as error:
        raise OutputError(f"{place}: cannot be replaced ({reason_of(error)})") from None

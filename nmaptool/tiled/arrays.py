"""Dask arrays of stores: pictures larger than memory for other programs, and from them."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.stores.opening import create_picture, open_picture, open_writable


def read_array(name: str) -> Any:
    """Return the stored values of a picture as a Dask array, read chunk by chunk when they are needed.

    Parameters
    ----------
    name : str
        A Zarr store, a folder of tiles, a TIFF or any other picture, such as the heights of `nmaptool.tiled.relief`.

    Returns
    -------
    dask.array.Array
        (H, W) or (H, W, C), of the stored type, in chunks of the store.

    Raises
    ------
    InputError
        If it cannot be read, or the extra is not installed.
    """
    da = _dask("dask.array")

    picture = open_picture(name)
    rows, cols = (_spans(size, side) for size, side in zip((picture.rows, picture.cols), picture.chunk, strict=True))
    channels = len(picture.channels)
    kept = (channels,) if channels > 1 else ()
    dtype = picture.read(slice(0, 1), slice(0, 1)).pixels.dtype

    def block(block_info: Any = None) -> Any:
        (top, bottom), (left, right), *_ = block_info[None]["array-location"]
        pixels = picture.read(slice(top, bottom), slice(left, right)).pixels
        return pixels if kept else pixels[..., 0]

    return da.map_blocks(block, chunks=(rows, cols, *((size,) for size in kept)), dtype=dtype)


def write_array(
    array: Any,
    name: str,
    channels: tuple[str, ...] = ("R", "G", "B"),
    *,
    pitch_mm: float | None = None,
    attributes: Mapping[str, Any] | None = None,
    chunk: int = 2048,
    overwrite: bool = False,
) -> None:
    """Write a Dask array as a Zarr store that the other functions read, block by block.

    Parameters
    ----------
    array : dask.array.Array or numpy.ndarray
        (H, W) or (H, W, C).
    name : str
        Zarr store.
    channels : tuple of str
        One name per channel.
    pitch_mm : float, optional
    attributes : mapping, optional
        As in `nmaptool.RasterImage`, such as ``{"kind": "normal"}``.
    chunk : int
        Side of a shard, a multiple of 64.
    overwrite : bool
        Replace a store that exists.

    Raises
    ------
    UsageError
        If the number of channels does not fit.
    OutputError
        If it exists or cannot be written.
    """
    dask = _dask("dask")
    da = _dask("dask.array")

    depth = array.shape[2] if array.ndim == 3 else 1
    if array.ndim not in (2, 3) or depth != len(channels):
        raise UsageError(f"`channels={channels}`: an array of shape {array.shape} has {depth} channels")
    rows, cols = array.shape[:2]
    inner = next(side for side in (512, 256, 128, 64, 1) if chunk % side == 0)
    create_picture(
        name, rows, cols, channels, array.dtype, chunk=chunk, inner=inner, pitch_mm=pitch_mm, attributes=attributes,
        overwrite=overwrite,
    )  # fmt: skip
    blocks = da.asarray(array).rechunk((chunk, chunk, *array.shape[2:]))

    def write(values: Any, row: int, col: int) -> None:
        open_writable(name).write(row, col, values)

    pieces = blocks.to_delayed()
    jobs = [
        dask.delayed(write)(pieces[(i, j, *(0,) * (array.ndim - 2))], i * chunk, j * chunk)
        for i in range(pieces.shape[0])
        for j in range(pieces.shape[1])
    ]
    dask.compute(*jobs)


def _dask(module: str) -> Any:
    """A module of Dask, which has hardly any types.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != "dask":
            raise
    raise InputError('Dask arrays need the package dask; install it with: pip install "nmaptool-relief[cluster]"')


def _spans(size: int, side: int) -> tuple[int, ...]:
    """Sizes of the chunks along an axis."""
    return tuple(min(side, size - first) for first in range(0, size, side))

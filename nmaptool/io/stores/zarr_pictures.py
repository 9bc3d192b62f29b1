"""Read pictures from Zarr arrays by windows; a chunk that is missing or damaged is an error."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.metadata import depth_facts
from nmaptool.io.pictures.sample_types import as_pixels, refuse_kind
from nmaptool.io.stores.extra import fsspec_module
from nmaptool.io.stores.names import local_path, split_name
from nmaptool.io.stores.windows import bounds, pieces
from nmaptool.io.stores.zarr_chunks import AbsentChunks
from nmaptool.io.stores.zarr_nodes import OWN, open_array
from nmaptool.types.picture import RasterImage

_CHANNELS = {1: ("Y",), 2: ("R", "G"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_MOST_CHANNELS = 4
_CHANNEL_NAMES = ("c", "channel")
# metadata that is not text for `RasterImage.attributes`
_NOT_TEXT = ("channels", "pitch_mm")


class ZarrPicture:
    """A picture in a Zarr array (H, W), (H, W, C) or (C, H, W); see `nmaptool.types.windows.PictureStore`.

    Further axes of length 1, such as the time and the depth of OME-Zarr, do not count.

    Parameters
    ----------
    name : str
        Path or URL of an array or of a group, with the array of the group after a colon.
    layer : str, optional
        The array of a group.

    Raises
    ------
    InputError
        If it cannot be opened, or does not hold a picture.
    """

    def __init__(self, name: str, layer: str | None = None) -> None:
        self._asked = (name, layer)
        self._array, self.layer, self.notes = open_array(name, layer)
        self.name = f"{name}:{self.layer}" if self.layer and ":" + self.layer not in name else name
        refuse_kind(self.name, self._array.dtype)
        self._axes = _axes(self.name, self._array)
        rows, cols, channel = self._axes
        self.rows, self.cols = (int(self._array.shape[axis]) for axis in (rows, cols))
        own = self._array.attrs.get(OWN)
        own = own if isinstance(own, Mapping) else {}
        count = 1 if channel is None else int(self._array.shape[channel])
        self.channels = _channels(self.name, own.get("channels"), count)
        unit = self._array.shards or self._array.chunks
        self.chunk = (int(unit[rows]), int(unit[cols]))
        self._inner = (int(self._array.chunks[rows]), int(self._array.chunks[cols]))
        self.pitch_mm = _pitch(own.get("pitch_mm"))
        self.attributes: Mapping[str, str] = {
            **{str(key): str(value) for key, value in own.items() if key not in _NOT_TEXT},
            **({} if self.pitch_mm is None else {"pitch_mm": repr(self.pitch_mm)}),
        }
        self._absent = None if own.get("absent_chunks") == "fill" else AbsentChunks(self._array)

    def __reduce__(self) -> tuple[Any, ...]:
        return ZarrPicture, self._asked

    def read(self, rows: slice, cols: slice) -> RasterImage:
        """Return one window as it is stored.

        Raises
        ------
        InputError
            If a chunk is missing or damaged, or the store cannot be reached.
        UsageError
            If the window does not lie in the picture.
        """
        window = bounds(self.name, rows, cols, (self.rows, self.cols))
        try:
            values = self._stored(window)
        except Exception as error:  # noqa: BLE001 - each codec and each file system has errors of its own
            raise self._reason(window, error) from None
        self._refuse_absent(values, window)
        pixels = as_pixels(self.name, values)
        return RasterImage(
            pixels=np.ascontiguousarray(pixels.values),
            channels=self.channels,
            name=self.name,
            bits=pixels.bits,
            attributes=self.attributes,
            layer=self.layer or None,
            depth_facts=depth_facts(self.attributes),
            notes=(*self.notes, *pixels.notes),
        )

    def stamp(self) -> str:
        """Return a text that changes when the stored pixels change, from sizes and times of files."""
        place = split_name(self._asked[0]).place + (f"/{self.layer}" if self.layer else "")
        path = local_path(place)
        found = hashlib.sha256()
        for entry in _files(path) if path is not None else _objects(place):
            found.update(repr(entry).encode())
        return found.hexdigest()

    def _stored(self, window: tuple[slice, slice]) -> NDArray[Any]:
        """The (h, w, C) stored values of a window."""
        rows, cols, channel = self._axes
        index = [slice(None)] * len(self._array.shape)
        index[rows], index[cols] = window
        values: NDArray[Any] = self._array[tuple(index)]
        order = (rows, cols) if channel is None else (rows, cols, channel)
        single = [axis for axis in range(values.ndim) if axis not in order]
        shape = (*(values.shape[axis] for axis in order), 1)[:3]
        return np.transpose(values, (*order, *single)).reshape(shape)

    def _refuse_absent(self, values: NDArray[Any], window: tuple[slice, slice]) -> None:
        """Refuse a window in which chunks are not stored: Zarr replaces them by the fill value."""
        if self._absent is None:
            return
        channel = self._axes[2]
        depth = values.shape[2] if channel is None else int(self._array.chunks[channel])
        for piece in pieces(window, self._inner):
            part = values[piece.window]
            for layer in range(0, values.shape[2], depth):
                if not self._absent.may_be(part[..., layer : layer + depth]):
                    continue
                key = self._absent.missing(piece.block, layer // depth, self._axes)
                if key is not None:
                    raise InputError(
                        f"{self.name}: the chunk {key} is missing; restore it, or, if missing chunks mean the fill "
                        f'value, set the array\'s attribute {OWN} to {{"absent_chunks": "fill"}}'
                    )

    def _reason(self, window: tuple[slice, slice], error: Exception) -> InputError:
        """The error about a window that cannot be read, with the first chunk that fails."""
        if isinstance(error, MemoryError):
            return InputError(f"{self.name}: a window of it does not fit in memory; make its chunks smaller")
        for piece in pieces(window, self.chunk):
            part = tuple(
                slice(whole.start + cut.start, whole.start + cut.stop)
                for whole, cut in zip(window, piece.window, strict=True)
            )
            try:
                self._stored((part[0], part[1]))
            except Exception as failed:  # noqa: BLE001 - as above
                key = AbsentChunks(self._array).key_of(piece.block, self._axes)
                if isinstance(failed, OSError) and not isinstance(failed, FileNotFoundError):
                    return InputError(f"{self.name}: the chunk {key} cannot be read ({_line(failed)})")
                return InputError(f"{self.name}: the chunk {key} is damaged; restore it or write the store again")
        return InputError(f"{self.name}: cannot be read ({_line(error)})")


def _line(error: Exception) -> str:
    return " ".join(str(getattr(error, "strerror", None) or error).split()) or type(error).__name__


def _axes(name: str, array: Any) -> tuple[int, int, int | None]:
    """The places of rows, columns and channels among the axes of an array."""
    shape = array.shape
    kept = list(range(len(shape)))
    for axis in range(len(shape)):
        if len(kept) > 3 and shape[axis] == 1:
            kept.remove(axis)
    if 0 in shape or len(kept) not in (2, 3):
        raise InputError(f"{name}: is an array of shape {shape}; expected (H, W), (H, W, C) or (C, H, W)")
    if len(kept) == 2:
        return kept[0], kept[1], None
    names = tuple(getattr(array.metadata, "dimension_names", None) or ())
    sides = [shape[axis] for axis in kept]
    first = names[kept[0]] in _CHANNEL_NAMES if names and names[kept[0]] else sides[2] > _MOST_CHANNELS >= sides[0]
    if sides[0 if first else 2] > _MOST_CHANNELS:
        raise InputError(f"{name}: is an array of shape {shape}; a picture has 1 to {_MOST_CHANNELS} channels")
    return (kept[1], kept[2], kept[0]) if first else (kept[0], kept[1], kept[2])


def _channels(name: str, stated: object, count: int) -> tuple[str, ...]:
    if stated is None:
        return _CHANNELS[count]
    names = tuple(str(one) for one in stated) if isinstance(stated, list | tuple) else ()
    if len(names) != count:
        raise InputError(f"{name}: states the channels {stated}, but has {count}; correct the attribute {OWN}")
    return names


def _pitch(stated: object) -> float | None:
    try:
        pitch = float(stated)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    return pitch if np.isfinite(pitch) and pitch > 0 else None


def _files(path: Path) -> list[tuple[str, int, int]]:
    """Names, sizes and times of all files of an array."""
    files = (one for one in path.rglob("*") if one.is_file())
    return sorted((one.relative_to(path).as_posix(), one.stat().st_size, one.stat().st_mtime_ns) for one in files)


def _objects(place: str) -> list[tuple[str, str]]:
    """Names of all objects of an array at a URL, with what the file system says about them."""
    files, root = fsspec_module(place).core.url_to_fs(place)
    told = ("size", "ETag", "etag", "mtime", "LastModified", "last_modified", "created", "updated")
    found = files.find(root, detail=True)
    return sorted((key, repr([str(one.get(word)) for word in told])) for key, one in found.items())

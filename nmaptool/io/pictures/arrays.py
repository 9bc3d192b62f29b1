"""Read pictures from NumPy array files: which axis holds the channels, which array of an archive is meant."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.array_files import Archive, ArrayHeader, load_npy
from nmaptool.io.pictures.layer_names import best_places, matching
from nmaptool.io.pictures.request import Request
from nmaptool.io.pictures.sample_types import as_pixels, refuse_kind
from nmaptool.types.picture import RasterImage

_CHANNELS = {1: ("Y",), 2: ("R", "G"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_ACCEPTED = "(rows, columns), (rows, columns, channels) or (channels, rows, columns) with 1 to 4 channels"


def picture_shape(shape: tuple[int, ...]) -> tuple[tuple[int, int, int], bool] | None:
    """Rows, columns and channels of an array, and whether its first axis holds the channels; None if it is no picture.

    Further axes of length 1 in front, such as that of a batch, do not count.

    >>> picture_shape((1, 3, 480, 640)), picture_shape((480, 640, 3)), picture_shape((1, 5, 7))
    (((480, 640, 3), True), ((480, 640, 3), False), ((5, 7, 1), True))
    """
    while len(shape) > 3 and shape[0] == 1:
        shape = shape[1:]
    if 0 in shape:
        return None
    if len(shape) == 2:
        return (shape[0], shape[1], 1), False
    if len(shape) != 3:
        return None
    if shape[2] in _CHANNELS and not (shape[2] == 1 and shape[0] in (2, 3, 4)):
        return (shape[0], shape[1], shape[2]), False
    if shape[0] in _CHANNELS:
        return (shape[1], shape[2], shape[0]), True
    return None


def _is_number(kind: np.dtype[Any]) -> bool:
    return kind.names is None and kind.kind in "biuf"


def read_npy(path: Path, request: Request) -> RasterImage:
    """Read an .npy file.

    Raises
    ------
    InputError, LimitError
    """
    request.refuse_layer(path, ".npy")
    return _picture(str(path), load_npy(path, _check(path, request)), request, None)


def read_npz(path: Path, request: Request) -> RasterImage:
    """Read the named or the obvious array of an .npz file.

    Raises
    ------
    InputError, LimitError
    """
    archive = Archive(path)
    key = _key(path, archive.headers, request)
    image = _picture(f"{path}:{key}", archive.load(key, _check(path, request)), request, key)
    others = [name for name in archive.headers if name != key]
    also = (f"also holds the arrays {', '.join(others)}",) if others else ()
    return replace(image, notes=(*image.notes, *also))


def _check(path: Path, request: Request) -> Any:
    """The check of an array's header."""

    def check(name: str, header: ArrayHeader) -> None:
        found = picture_shape(header.shape)
        if header.kind.names is not None:
            raise InputError(f"{name}: holds records ({', '.join(header.kind.names)}), not a picture; save one field")
        refuse_kind(name, header.kind)
        if found is None:
            raise InputError(f"{name}: holds an array of shape {header.shape}; accepted are {_ACCEPTED}")
        request.check_size(path, found[0][1], found[0][0])

    return check


def _key(path: Path, headers: dict[str, ArrayHeader | None], request: Request) -> str:
    """The name of the wanted array, or of the one that can be meant."""
    listing = ", ".join(headers)
    if request.layer is not None:
        names = list(headers)
        wanted = matching(request.layer, [[name] for name in names])
        if len(wanted) == 1:
            return names[wanted[0]]
        raise InputError(f"{path}: has no array {request.layer!r}; it holds: {listing}")
    if len(headers) == 1:  # the checks before loading say what is wrong with it
        return next(iter(headers))
    shapes = {
        name: found[0]
        for name, header in headers.items()
        if header is not None and _is_number(header.kind) and (found := picture_shape(header.shape)) is not None
    }
    counts = (2, 3, 4) if request.holds == "normals" else (1,)
    for fitting in ([n for n, shape in shapes.items() if shape[2] in counts and min(shape[:2]) > 1], list(shapes)):
        places = [0] if len(fitting) == 1 else best_places(fitting, request.holds)
        if len(places) == 1:
            return fitting[places[0]]
    if not shapes:
        raise InputError(f"{path}: none of its arrays ({listing}) is a picture; accepted are {_ACCEPTED}")
    example = f"{path.name}:{next(iter(shapes))}"
    raise InputError(f"{path}: holds several arrays ({listing}); name one, such as {example}")


def _picture(name: str, values: NDArray[Any], request: Request, layer: str | None) -> RasterImage:
    """The picture of an array that passed the check."""
    found = picture_shape(values.shape)
    assert found is not None
    (rows, cols, count), first = found
    notes: tuple[str, ...] = ()
    if first and count > 1:
        values = np.moveaxis(values.reshape(count, rows, cols), 0, -1)
        notes = ("its first axis holds the channels",)
    values = values.reshape(rows, cols, count)
    codes = _as_mask(values) if request.holds == "grey" and count == 1 else _as_codes(values)
    if codes is not None:
        values, notes = codes, (*notes, "its numbers are whole and go from 0 to 255: they are read as 8-bit codes")
    pixels = as_pixels(name, values)
    channels = _CHANNELS[count]
    numbers = pixels.values
    if count == 4 and numbers.dtype == np.float32 and not _is_alpha(numbers[..., 3]):
        numbers, channels = numbers[..., :3], channels[:3]
        notes = (*notes, "its fourth channel goes beyond 0 to 1, so it is not read as alpha")
    return RasterImage(
        np.ascontiguousarray(numbers), channels, name, pixels.bits, layer=layer, notes=(*notes, *pixels.notes)
    )


def _is_alpha(values: NDArray[Any]) -> bool:
    return bool(values.min() >= 0 and values.max() <= 1)


def _as_mask(values: NDArray[Any]) -> NDArray[np.uint8] | None:
    """A mask as 8-bit codes, if integers of any size hold only 0 and 1, or wider numbers only 0 to 255."""
    if values.dtype.kind == "b" or values.min() != 0:
        return None
    if values.dtype.kind in "iu" and values.max() == 1:
        return values.astype(np.uint8) * np.uint8(255)
    codes = values.astype(np.uint8) if values.max() == 255 else None
    return codes if codes is not None and np.array_equal(codes, values) else None


def _as_codes(values: NDArray[Any]) -> NDArray[np.uint8] | None:
    """Colours as 8-bit codes if wider numbers hold only those, as programs leave them after reading a PNG."""
    if values.shape[2] < 3 or values.dtype.kind == "b" or values.dtype.itemsize == 1 or values.dtype == np.uint16:
        return None
    if not (values.min() >= 0 and 8 < values.max() <= 255):
        return None
    codes = values.astype(np.uint8)
    return codes if np.array_equal(codes, values) else None

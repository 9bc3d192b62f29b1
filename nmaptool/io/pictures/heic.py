"""Read HEIC photos and the depth images in them, with pi-heif or pillow-heif if one of them is installed."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.types.picture import RasterImage

# the second reads the same and also writes, with a library under the GPL
_MODULES = ("pi_heif", "pillow_heif")
_CHANNELS = {1: ("Y",), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_DAMAGE = (ValueError, EOFError, RuntimeError, OSError, SyntaxError, LookupError, TypeError)
_DEPTH = "depth"
# kinds of depth image, see libheif; of these, larger numbers are farther away
_FAR_IS_LARGE = 2


def read_heic(path: Path, request: Request) -> RasterImage:
    """Read a photo, or its depth image if the request is for depth or for the layer ``depth``.

    Raises
    ------
    InputError
        Also if no library for this format is installed, or the photo has no depth image.
    LimitError
    """
    heif = _library(path)
    if request.layer is not None and request.layer.lower() not in (_DEPTH, "photo"):
        raise InputError(f"{path}: has no layer {request.layer!r}; it holds: photo, depth")
    try:
        photo = heif.open_heif(path, convert_hdr_to_8bit=False)
        cols, rows = photo.size
        request.check_size(path, cols, rows)
        found = photo.info.get("depth_images") or []
        if (request.layer is None and request.holds == "depth") or (request.layer or "").lower() == _DEPTH:
            return _depth(path, found, (cols, rows), request)
        others = (f"also holds a depth image: {path.name}:depth",) if found else ()
        return _image(path, photo, None, ("is a photo", *others))
    except _DAMAGE as error:
        if isinstance(error, InputError):
            raise
        raise damaged(path, "HEIC") from None
    except MemoryError:
        raise LimitError(f"{path}: does not fit in memory; make it smaller") from None


def _library(path: Path) -> Any:
    for name in _MODULES:
        try:
            return import_module(name)
        except ImportError:
            continue
    raise InputError(
        f"{path}: is a HEIC photo; export its depth image as PNG, or install the reader: "
        'pip install "nmaptool-relief[heic]"'
    )


def _depth(path: Path, found: list[Any], size: tuple[int, int], request: Request) -> RasterImage:
    if not found:
        raise InputError(
            f"{path}: is a photo without a depth image (portrait mode stores one); give a depth picture, or "
            f"`layer='photo'` for the photo itself"
        )
    cols, rows = found[0].size
    request.check_size(path, cols, rows)
    said = found[0].info.get("metadata") or {}
    notes = [f"is the depth image of {cols} x {rows} px in a photo of {size[0]} x {size[1]} px"]
    if said.get("representation_type") == _FAR_IS_LARGE:
        notes.append("its larger numbers are farther away; use `invert=True`")
    return _image(path, found[0], _DEPTH, tuple(notes))


def _image(path: Path, image: Any, layer: str | None, notes: tuple[str, ...]) -> RasterImage:
    name = str(path) if layer is None else f"{path}:{layer}"
    values: NDArray[Any] = np.array(image, copy=True)  # its memory lasts only as long as the image
    values = values[:, : image.size[0]]
    values = values[..., None] if values.ndim == 2 else values
    if values.shape[2] not in _CHANNELS:
        raise InputError(f"{name}: has {values.shape[2]} channels; a picture has 1, 3 or 4")
    pixels = as_pixels(name, values)
    channels = _CHANNELS[values.shape[2]]
    return RasterImage(
        np.ascontiguousarray(pixels.values), channels, name, pixels.bits, lossy=True, layer=layer, notes=notes
    )

"""Read pictures through OpenImageIO: only supported formats, unassociated alpha, codes without colour management."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - the name in its documentation
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures import exr_layers as layers
from nmaptool.io.pictures import png
from nmaptool.io.pictures.formats import JPEG, PNG, PictureFormat, find_format
from nmaptool.io.pictures.metadata import depth_facts, own_attributes
from nmaptool.types.picture import RasterImage

_LARGEST_PIXEL_BYTES = 16  # four float channels


def error_text(source: Any) -> str:
    """Return and clear the last error of an OpenImageIO reader or writer, or of the library, on one line."""
    try:
        text = source.geterror()
    except UnicodeDecodeError:
        text = ""
    return " ".join(str(text).split()) or "unreadable data"


def _check_jpeg_end(path: Path) -> None:
    """Refuse a JPEG without its end mark: the decoder would silently fill the missing part with grey."""
    data = path.read_bytes()
    if data.find(b"\xff\xd9", max(data.rfind(b"\xff\xda"), 0)) < 0:
        raise InputError(f"{path}: the JPEG file is truncated or damaged; export or download it again")


def _check_claim(path: Path, reason: str, max_megapixels: float) -> None:
    """Apply our own limit to a size that OpenImageIO refused with a message like ``... 100000x100000 ...``."""
    claims = re.findall(r"(\d{4,})x(\d{4,})", reason)
    if claims:
        cols, rows = (int(side) for side in claims[-1])
        png.check_size(path, cols, rows, max_megapixels)
        raise LimitError(f"{path}: {cols} x {rows} does not fit in memory; make it smaller")


def _openable(path: Path) -> str:
    """Return the path as UTF-8 text, which OpenImageIO needs; refuse names in other encodings."""
    try:
        return str(path).encode().decode()
    except UnicodeEncodeError:
        shown = str(path).encode("utf-8", "replace").decode()
        raise InputError(f"{shown}: has a name that is not valid UTF-8; rename it") from None


def _open(path: Path, max_megapixels: float) -> tuple[Any, PictureFormat, png.PngStructure | None]:
    """Return an open OpenImageIO input, the format, and the structure of a PNG."""
    kind = find_format(path)
    if kind is JPEG:
        _check_jpeg_end(path)
    structure = png.read_structure(path, max_megapixels) if kind is PNG else None
    if structure is not None and not structure.is_possible:
        raise InputError(f"{path}: the PNG file is truncated or damaged; export or download it again")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    # our own limit, so that the result does not depend on the memory of the machine
    allowed = int(max_megapixels * _LARGEST_PIXEL_BYTES) + 1 if math.isfinite(max_megapixels) else 0
    oiio.attribute("limits:imagesize_MB", min(allowed, 2**31 - 1))
    source = oiio.ImageInput.open(_openable(path), config)  # bytes and extension agree, so no other reader is tried
    if source is None:
        reason = error_text(oiio)
        _check_claim(path, reason, max_megapixels)
        what = "header claims more than the file can hold" if "header claims" in reason else "file cannot be decoded"
        raise InputError(f"{path}: the {kind.name} {what}; export or download it again")
    return source, kind, structure


def read_image(path: Path, layer: str | None = None, max_megapixels: float = 270.0) -> RasterImage:
    """Read a picture as its file stores it.

    Parameters
    ----------
    path : Path
        PNG, EXR, TIFF, JPEG or BMP, recognised by its bytes.
    layer : str, optional
        Layer or part of an EXR.
    max_megapixels : float
        Refuse larger pictures, before anything is allocated.

    Raises
    ------
    InputError
        If it cannot be read, or does not have the layer.
    LimitError
        If its declared size is larger than ``max_megapixels``.
    """
    source, kind, structure = _open(path, max_megapixels)
    try:
        parts = _parts(source)
        for spec in parts:
            cols, rows = max(spec.width, spec.full_width), max(spec.height, spec.full_height)
            png.check_size(path, cols, rows, max_megapixels)
        chosen = layers.choose(path, parts, layer)
        if parts[chosen.part].deep:
            raise InputError(f"{path}: holds deep data (many samples per pixel); flatten it on export")
        source.seek_subimage(chosen.part, 0)
        return _read_layer(path, source, kind, structure, chosen)
    finally:
        source.close()


@dataclass(frozen=True, eq=False)
class PlacedImage:
    """A part of a file with its place on the canvas, in its own data window.

    Parameters
    ----------
    image : RasterImage
    left, top : int
        Position of its data window in the display window.
    cols, rows : int
        Size of the display window.
    """

    image: RasterImage
    left: int
    top: int
    cols: int
    rows: int


def read_pages(path: Path, max_megapixels: float = 270.0) -> list[PlacedImage]:
    """Read all layers, parts and pages of a file.

    Raises
    ------
    InputError, LimitError
        As `read_image`; the limit applies to all of them together.
    """
    source, kind, structure = _open(path, max_megapixels)
    try:
        parts = _parts(source)
        found = layers.find(parts)
        total = 0
        for layer in found:
            spec = parts[layer.part]
            if spec.deep:
                raise InputError(f"{path}: holds deep data (many samples per pixel); flatten it on export")
            png.check_size(path, spec.full_width, spec.full_height, max_megapixels)
            total += spec.width * spec.height
        if total > max_megapixels * 1e6:
            raise LimitError(
                f"{path}: its layers hold {total / 1e6:.3g} megapixels together, more than the limit of "
                f"{max_megapixels:g}; crop them or raise `max_megapixels`"
            )
        return [_read_placed(path, source, kind, structure, layer) for layer in found]
    finally:
        source.close()


def _read_placed(
    path: Path, source: Any, kind: PictureFormat, structure: png.PngStructure | None, layer: layers.Layer
) -> PlacedImage:
    source.seek_subimage(layer.part, 0)
    spec = source.spec()
    layer = replace(layer, name=layer.name or None)
    image = _read_layer(path, source, kind, structure, layer, placed=True)
    return PlacedImage(image, spec.x - spec.full_x, spec.y - spec.full_y, spec.full_width, spec.full_height)


def _parts(source: Any) -> list[Any]:
    """Specs of all parts, copied before the reader moves on."""
    parts: list[Any] = []
    while source.seek_subimage(len(parts), 0):
        parts.append(oiio.ImageSpec(source.spec()))
    error_text(source)  # clear the expected error of seeking past the last part
    return parts


def _read_layer(
    path: Path,
    source: Any,
    kind: PictureFormat,
    structure: png.PngStructure | None,
    chosen: layers.Layer,
    *,
    placed: bool = False,
) -> RasterImage:
    """Read the layer onto the canvas or, with ``placed``, into its own data window."""
    spec = source.spec()
    stored = str(spec.format)
    wanted = {"uint8": oiio.UINT8, "uint16": oiio.UINT16}.get(stored, oiio.FLOAT)
    if stored not in ("uint8", "uint16", "half", "float"):
        raise InputError(f"{path}: stores {stored} values; export it as 8- or 16-bit integers, half or float")
    try:
        pixels = source.read_image(chosen.part, 0, 0, spec.nchannels, wanted)
    except MemoryError:
        raise LimitError(f"{path}: {spec.width} x {spec.height} does not fit in memory; make it smaller") from None
    if pixels is None:
        raise InputError(f"{path}: the {kind.name} file is truncated or damaged; export or download it again")
    pixels = layers.pick(pixels, chosen)
    if not placed:
        pixels, chosen = _on_canvas(spec, pixels, chosen)
    colors = structure.color_chunks if structure is not None else ()
    if structure is None and spec.getattribute("ICCProfile") is not None:
        colors = ("ICC profile",)
    attributes = own_attributes(spec)
    return RasterImage(
        pixels=np.ascontiguousarray(pixels),
        channels=chosen.channels,
        name=f"{path}:{chosen.name}" if chosen.name else str(path),
        bits={"uint8": 8, "uint16": 16, "half": 16}.get(stored, 32),
        lossy=kind is JPEG or "jpeg" in str(spec.getattribute("compression")),
        attributes=attributes,
        color_chunks=colors,
        layer=chosen.name,
        depth_facts=depth_facts(attributes),
    )


def _on_canvas(spec: Any, pixels: NDArray[Any], chosen: layers.Layer) -> tuple[NDArray[Any], layers.Layer]:
    """Put an EXR's data window at its place in the display window; the rest is transparent."""
    data = (spec.x, spec.y, spec.width, spec.height)
    full = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if data == full or full[2] < 1 or full[3] < 1:
        return pixels, chosen
    if "A" not in chosen.channels:
        opaque = np.full((*pixels.shape[:2], 1), 1 if pixels.dtype == np.float32 else np.iinfo(pixels.dtype).max)
        pixels = np.concatenate([pixels, opaque.astype(pixels.dtype)], axis=2)
        chosen = layers.Layer(chosen.name, chosen.part, chosen.indices, (*chosen.channels, "A"))
    canvas = np.zeros((full[3], full[2], pixels.shape[2]), pixels.dtype)
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    x0, x1 = max(left, 0), min(left + spec.width, full[2])
    y0, y1 = max(top, 0), min(top + spec.height, full[3])
    if x0 < x1 and y0 < y1:
        canvas[y0:y1, x0:x1] = pixels[y0 - top : y1 - top, x0 - left : x1 - left]
    return canvas, chosen

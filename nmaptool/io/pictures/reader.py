"""Pictures through OpenImageIO: formats we allow only, alpha unassociated, codes untouched by colour management."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures import exr_layers as layers
from nmaptool.io.pictures import png
from nmaptool.io.pictures.formats import JPEG, PNG, PictureFormat, find_format
from nmaptool.io.pictures.metadata import depth_facts, own_attributes
from nmaptool.types.picture import RasterImage

_LARGEST_PIXEL_BYTES = 16  # four float channels


def error_text(source: Any) -> str:
    """OpenImageIO's last error of a reader, a writer or the library, on one line; fetching it clears it."""
    try:
        text = source.geterror()
    except UnicodeDecodeError:
        text = ""
    return " ".join(str(text).split()) or "unreadable data"


def _check_jpeg_end(path: Path) -> None:
    """Refuse a JPEG without its end mark: the decoder would fill what is missing with grey, in silence."""
    data = path.read_bytes()
    if data.find(b"\xff\xd9", max(data.rfind(b"\xff\xda"), 0)) < 0:
        raise InputError(f"{path}: the JPEG file is cut short or damaged; export or download it again")


def _check_claim(path: Path, reason: str, max_megapixels: float) -> None:
    """Refuse by our own limit a size that the reader itself refused, in its words ``... 100000x100000 ...``."""
    claims = re.findall(r"(\d{4,})x(\d{4,})", reason)
    if claims:
        cols, rows = (int(side) for side in claims[-1])
        png.check_size(path, cols, rows, max_megapixels)
        raise LimitError(f"{path}: {cols} x {rows} does not fit in memory; make it smaller")


def _openable(path: Path) -> str:
    """The path as text, which is all that OpenImageIO takes; names in another encoding are not."""
    try:
        return str(path).encode().decode()
    except UnicodeEncodeError:
        shown = str(path).encode("utf-8", "replace").decode()
        raise InputError(f"{shown}: has a name that is not valid UTF-8; rename it") from None


def _open(path: Path, max_megapixels: float) -> tuple[Any, PictureFormat, png.PngStructure | None]:
    """An open OpenImageIO input, the format, and a PNG's structure."""
    kind = find_format(path)
    if kind is JPEG:
        _check_jpeg_end(path)
    structure = png.read_structure(path, max_megapixels) if kind is PNG else None
    if structure is not None and not structure.is_possible:
        raise InputError(f"{path}: the PNG file is cut short or damaged; export or download it again")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    # a limit of our own, so that the reader's answer does not depend on the machine's memory
    allowed = int(max_megapixels * _LARGEST_PIXEL_BYTES) + 1 if math.isfinite(max_megapixels) else 0
    oiio.attribute("limits:imagesize_MB", min(allowed, 2**31 - 1))
    source = oiio.ImageInput.open(_openable(path), config)  # bytes and ending agree: no other reader is tried
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
        Refuse more before anything is allocated.

    Raises
    ------
    InputError
        If it cannot be read, or the layer is not in it.
    LimitError
        If it claims to be larger than ``max_megapixels``.
    """
    source, kind, structure = _open(path, max_megapixels)
    try:
        parts = _parts(source)
        for spec in parts:
            cols, rows = max(spec.width, spec.full_width), max(spec.height, spec.full_height)
            png.check_size(path, cols, rows, max_megapixels)
        chosen = layers.choose(path, parts, layer)
        if parts[chosen.part].deep:
            raise InputError(f"{path}: holds deep data (many samples a pixel); flatten it on export")
        source.seek_subimage(chosen.part, 0)
        return _read_layer(path, source, kind, structure, chosen)
    finally:
        source.close()


@dataclass(frozen=True, eq=False)
class PlacedImage:
    """A part of a file at its place: not yet on the canvas.

    Parameters
    ----------
    image : RasterImage
    left, top : int
        Of its data window in the display window.
    cols, rows : int
        Of the display window.
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
        As `read_image`; the limit is on all of them together.
    """
    source, kind, structure = _open(path, max_megapixels)
    try:
        parts = _parts(source)
        found = layers.find(parts)
        total = 0
        for layer in found:
            spec = parts[layer.part]
            if spec.deep:
                raise InputError(f"{path}: holds deep data (many samples a pixel); flatten it on export")
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
    error_text(source)  # there is always one part less than asked for; that is no error
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
    """The layer on the canvas, or (``placed``) in its own data window."""
    spec = source.spec()
    stored = str(spec.format)
    wanted = {"uint8": oiio.UINT8, "uint16": oiio.UINT16}.get(stored, oiio.FLOAT)
    if stored not in ("uint8", "uint16", "half", "float"):
        raise InputError(f"{path}: stores {stored} numbers; accepted are 8 or 16 bit integers, half and float")
    try:
        pixels = source.read_image(chosen.part, 0, 0, spec.nchannels, wanted)
    except MemoryError:
        raise LimitError(f"{path}: {spec.width} x {spec.height} does not fit in memory; make it smaller") from None
    if pixels is None:
        raise InputError(f"{path}: the {kind.name} file is cut short or damaged; export or download it again")
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
    """Put an EXR's data window at its place in the display window; what it leaves out is transparent."""
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

"""Read pictures through OpenImageIO: unassociated alpha, codes without colour management, pixels not turned."""

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
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.formats import PictureFormat, find_format
from nmaptool.io.pictures.metadata import depth_facts, own_attributes
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.io.pictures.size_limit import check_size
from nmaptool.types.picture import RasterImage

_LARGEST_PIXEL_BYTES = 16  # four float channels
# the type in which samples are read, so that OpenImageIO never scales them; half is exact in float
_AS_STORED = {"uint8": oiio.UINT8, "uint16": oiio.UINT16, "uint": oiio.UINT32, "int8": oiio.INT8, "int16": oiio.INT16}
_AS_STORED |= {"int": oiio.INT32, "half": oiio.FLOAT, "float": oiio.FLOAT, "double": oiio.DOUBLE}


@dataclass(frozen=True, eq=False)
class Source:
    """A file that OpenImageIO has opened."""

    path: Path
    kind: PictureFormat
    facts: Facts
    reader: Any

    def parts(self) -> list[Any]:
        """Specs of all parts, copied before the reader moves on."""
        parts: list[Any] = []
        while self.reader.seek_subimage(len(parts), 0):
            parts.append(oiio.ImageSpec(self.reader.spec()))
        error_text(self.reader)  # clear the expected error of seeking past the last part
        return parts


def error_text(source: Any) -> str:
    """Return and clear the last error of an OpenImageIO reader or writer, or of the library, on one line."""
    try:
        text = source.geterror()
    except UnicodeDecodeError:
        text = ""
    return " ".join(str(text).split()) or "unreadable data"


def _check_claim(path: Path, reason: str, max_megapixels: float) -> None:
    """Apply our own limit to a size that OpenImageIO refused with a message like ``... 100000x100000 ...``."""
    claims = re.findall(r"(\d{4,})x(\d{4,})", reason)
    if claims:
        cols, rows = (int(side) for side in claims[-1])
        check_size(path, cols, rows, max_megapixels)
        raise LimitError(f"{path}: {cols} x {rows} does not fit in memory; make it smaller")


def _openable(path: Path) -> str:
    """Return the path as UTF-8 text, which OpenImageIO needs; refuse names in other encodings."""
    try:
        return str(path).encode().decode()
    except UnicodeEncodeError:
        shown = str(path).encode("utf-8", "replace").decode()
        raise InputError(f"{shown}: has a name that is not valid UTF-8; rename it") from None


def open_source(path: Path, request: Request) -> Source:
    """Check a file and open it with OpenImageIO.

    Raises
    ------
    InputError, LimitError
    """
    kind = find_format(path)
    facts = kind.function(kind.check)(path, request) if kind.check else Facts()
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    # our own limit, so that the result does not depend on the memory of the machine
    limit = request.max_megapixels
    allowed = int(limit * _LARGEST_PIXEL_BYTES) + 1 if math.isfinite(limit) else 0
    oiio.attribute("limits:imagesize_MB", min(allowed, 2**31 - 1))
    reader = oiio.ImageInput.open(_openable(path), config)  # bytes and extension agree, so no other reader is tried
    if reader is None:
        reason = error_text(oiio)
        _check_claim(path, reason, limit)
        if "ubsampled channels" in reason:
            raise InputError(f"{path}: stores colour at half resolution; export red, green and blue at full resolution")
        what = "header claims more than the file can hold" if "header claims" in reason else "file cannot be decoded"
        raise InputError(f"{path}: the {kind.name} {what}; export or download it again")
    return Source(path, kind, facts, reader)


def read_checked(path: Path, request: Request) -> RasterImage:
    """Read a picture of a format that OpenImageIO reads, after the check that its entry in the table names.

    Raises
    ------
    InputError, LimitError
    """
    source = open_source(path, request)
    try:
        parts = source.parts()
        for spec in parts:
            cols, rows = max(spec.width, spec.full_width), max(spec.height, spec.full_height)
            request.check_size(path, cols, rows)
        chosen = layers.choose(path, parts, request, pages=source.facts.pages, names=source.facts.names)
        refuse_deep(path, parts[chosen.part])
        return read_layer(source, chosen)
    finally:
        source.reader.close()


def refuse_deep(path: Path, spec: Any) -> None:
    """Refuse many samples per pixel.

    Raises
    ------
    InputError
    """
    if spec.deep:
        raise InputError(f"{path}: holds deep data (many samples per pixel); flatten it on export")


def read_layer(source: Source, chosen: layers.Layer, *, placed: bool = False) -> RasterImage:
    """Read the layer onto the canvas or, with ``placed``, into its own data window.

    Raises
    ------
    InputError, LimitError
    """
    refuse_numbers(source, chosen)
    source.reader.seek_subimage(chosen.part, 0)
    spec = source.reader.spec()
    values, stored = _samples(source, spec, chosen)
    return picture_of(source, spec, chosen, values, stored, placed=placed)


def refuse_numbers(source: Source, chosen: layers.Layer) -> None:
    """Refuse a layer whose numbers are not read.

    Raises
    ------
    InputError
    """
    refusal = source.facts.of_part(chosen.part).refusal
    if refusal:
        raise InputError(f"{source.path}: {refusal}")


def picture_of(
    source: Source, spec: Any, chosen: layers.Layer, values: NDArray[Any], stored: str, *, placed: bool
) -> RasterImage:
    """Make a picture of the stored samples of a layer, or of a window of it.

    Parameters
    ----------
    source : Source
    spec : ImageSpec
        Of the layer's part.
    chosen : Layer
    values : (H, W, C)
        The samples of its channels.
    stored : str
        The name of their type in OpenImageIO.
    placed : bool
        Leave them in their own data window.

    Raises
    ------
    InputError
    """
    path, facts = source.path, source.facts.of_part(chosen.part)
    if facts.white_is_zero and values.dtype.itemsize > 1:  # OpenImageIO turns only those of up to 8 bits
        values = np.iinfo(values.dtype).max - values
    pixels, bits, number_notes = as_pixels(str(path), values)
    chosen, pixels = _named(facts, chosen, pixels)
    if not placed:
        pixels, chosen = _on_canvas(spec, pixels, chosen)
    colors = facts.color_chunks
    if not colors and source.kind.name != "PNG" and spec.getattribute("ICCProfile") is not None:
        colors = ("ICC profile",)
    attributes = {**own_attributes(spec), **facts.attributes}
    orientation = spec.get_int_attribute("Orientation", 1)
    return RasterImage(
        pixels=np.ascontiguousarray(pixels),
        channels=chosen.channels,
        name=f"{path}:{chosen.name}" if chosen.name else str(path),
        bits=16 if stored == "half" else bits,
        lossy=facts.lossy or "jpeg" in str(spec.getattribute("compression")),
        attributes=attributes,
        color_chunks=colors,
        layer=chosen.name,
        depth_facts=depth_facts(attributes),
        nodata=facts.nodata,
        orientation=orientation if 1 <= orientation <= 8 else 1,
        notes=(*facts.notes, *chosen.notes, *number_notes),
        coarse=facts.coarse,
    )


def _samples(source: Source, spec: Any, chosen: layers.Layer) -> tuple[NDArray[Any], str]:
    """The layer's channels as stored, and the name of their type."""
    first, last = channel_span(chosen)
    stored, kind = stored_type(source.path, spec, chosen)
    try:
        values = source.reader.read_image(chosen.part, 0, first, last, kind)
    except MemoryError:
        raise LimitError(
            f"{source.path}: {spec.width} x {spec.height} does not fit in memory; make it smaller"
        ) from None
    if values is None:
        raise damaged(source.path, source.kind.name)
    return chosen_channels(values, chosen), stored


def channel_span(chosen: layers.Layer) -> tuple[int, int]:
    """The first channel of a layer, and that after its last."""
    return min(chosen.indices), max(chosen.indices) + 1


def chosen_channels(values: NDArray[Any], chosen: layers.Layer) -> NDArray[Any]:
    """The channels of a layer from samples of all channels between its first and its last."""
    first, last = channel_span(chosen)
    wanted = [i - first for i in chosen.indices]
    return values if wanted == list(range(last - first)) else values[..., wanted]


def stored_type(path: Path, spec: Any, chosen: layers.Layer) -> tuple[str, Any]:
    """The type of a layer's samples, its name and that in which to read them.

    Raises
    ------
    InputError
        If they are of an unknown type.
    """
    own = [str(spec.channelformat(i)) for i in chosen.indices]
    stored = own[0] if len(set(own)) == 1 else "float"
    if stored not in _AS_STORED:
        raise InputError(f"{path}: stores {stored} values; export it as integers of 8 or 16 bits, half or float")
    return stored, _AS_STORED[stored]


def _named(facts: Facts, chosen: layers.Layer, pixels: NDArray[Any]) -> tuple[layers.Layer, NDArray[Any]]:
    """Correct the names of the channels as the format's check found them."""
    if facts.channels and len(facts.channels) == len(chosen.channels):
        chosen = replace(chosen, channels=facts.channels)
    if facts.spare_alpha and chosen.channels[-1] == "A" and np.ptp(pixels[..., -1]) == 0:
        return replace(chosen, channels=chosen.channels[:-1]), pixels[..., :-1]
    return chosen, pixels


def _on_canvas(spec: Any, pixels: NDArray[Any], chosen: layers.Layer) -> tuple[NDArray[Any], layers.Layer]:
    """Put an EXR's data window at its place in the display window; the rest is transparent."""
    data = (spec.x, spec.y, spec.width, spec.height)
    full = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if data == full or full[2] < 1 or full[3] < 1:
        return pixels, chosen
    if "A" not in chosen.channels:
        opaque = np.full((*pixels.shape[:2], 1), 1 if pixels.dtype == np.float32 else np.iinfo(pixels.dtype).max)
        pixels = np.concatenate([pixels, opaque.astype(pixels.dtype)], axis=2)
        chosen = replace(chosen, channels=(*chosen.channels, "A"))
    canvas = np.zeros((full[3], full[2], pixels.shape[2]), pixels.dtype)
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    x0, x1 = max(left, 0), min(left + spec.width, full[2])
    y0, y1 = max(top, 0), min(top + spec.height, full[3])
    if x0 < x1 and y0 < y1:
        canvas[y0:y1, x0:x1] = pixels[y0 - top : y1 - top, x0 - left : x1 - left]
    return canvas, chosen

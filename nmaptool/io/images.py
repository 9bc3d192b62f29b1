"""Pictures through OpenImageIO: formats we allow only, alpha unassociated, codes untouched by colour management."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
from numpy.typing import NDArray

from nmaptool.errors import InputError, LimitError, OutputError
from nmaptool.io import layers, png
from nmaptool.model import RasterImage

PREFIX = "nmaptool:"
_MAGIC = {
    b"\x89PNG": "png",
    b"\x76\x2f\x31\x01": "openexr",
    b"II*\0": "tiff",
    b"MM\0*": "tiff",
    b"II+\0": "tiff",
    b"MM\0+": "tiff",
    b"\xff\xd8\xff": "jpeg",
    b"BM": "bmp",
}
_ENDINGS = {
    "png": (".png",),
    "openexr": (".exr",),
    "tiff": (".tif", ".tiff"),
    "jpeg": (".jpg", ".jpeg"),
    "bmp": (".bmp",),
}
_ACCEPTED = "PNG, EXR, TIFF, JPEG or BMP"


def _error_text(source: Any) -> str:
    try:
        text = source.geterror()
    except UnicodeDecodeError:
        text = ""
    return " ".join(str(text).split()) or "unreadable data"


def sniff(path: Path) -> str:
    """OpenImageIO's name of the format that the file's first bytes tell.

    Raises
    ------
    InputError
        If the file is missing, a folder, empty, none of the formats read here, or has another format's ending.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(8)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give a picture file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if not head:
        raise InputError(f"{path}: is empty; export or download it again")
    for magic, kind in _MAGIC.items():
        if head.startswith(magic):
            if path.suffix and path.suffix.lower() not in _ENDINGS[kind]:
                right = path.with_suffix(_ENDINGS[kind][0]).name
                raise InputError(f"{path}: holds {kind} data but is not named so; rename it to {right}")
            return kind
    raise InputError(f"{path}: is not a picture that can be read here; accepted are {_ACCEPTED}")


def _open(path: Path, max_megapixels: float) -> tuple[Any, str, png.PngStructure | None]:
    """An open OpenImageIO input, the format, and a PNG's structure."""
    kind = sniff(path)
    structure = png.read_structure(path, max_megapixels) if kind == "png" else None
    if structure is not None and not structure.is_possible:
        raise InputError(f"{path}: the PNG file is cut short or damaged; export or download it again")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)  # bytes and ending agree: no other reader is tried
    if source is None:
        reason = _error_text(oiio)
        raise InputError(f"{path}: the {kind} file cannot be read ({reason}); export or download it again")
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


def _parts(source: Any) -> list[Any]:
    """Specs of all parts, copied before the reader moves on."""
    parts: list[Any] = []
    while source.seek_subimage(len(parts), 0):
        parts.append(oiio.ImageSpec(source.spec()))
    return parts


def _read_layer(
    path: Path, source: Any, kind: str, structure: png.PngStructure | None, chosen: layers.Layer
) -> RasterImage:
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
        reason = _error_text(source)
        raise InputError(f"{path}: the {kind} file is cut short or damaged ({reason}); export or download it again")
    pixels, chosen = _on_canvas(spec, layers.pick(pixels, chosen), chosen)
    colors = structure.color_chunks if structure is not None else ()
    if structure is None and spec.getattribute("ICCProfile") is not None:
        colors = ("ICC profile",)
    return RasterImage(
        pixels=np.ascontiguousarray(pixels),
        channels=chosen.channels,
        name=str(path) if chosen.name is None else f"{path}:{chosen.name}",
        bits={"uint8": 8, "uint16": 16, "half": 16}.get(stored, 32),
        lossy=kind == "jpeg",
        attributes=_own_attributes(spec),
        color_chunks=colors,
        layer=chosen.name,
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


def _own_attributes(spec: Any) -> dict[str, str]:
    own = {a.name[len(PREFIX) :]: str(a.value) for a in spec.extra_attribs if a.name.startswith(PREFIX)}
    if not own:  # TIFF has no free-form attributes: they travel in its description
        for line in str(spec.getattribute("ImageDescription") or "").splitlines():
            key, mark, value = line.partition("=")
            if mark and key.startswith(PREFIX):
                own[key[len(PREFIX) :]] = value
    return own


def write_image(
    path: Path,
    pixels: NDArray[Any],
    channels: tuple[str, ...],
    attributes: Mapping[str, str],
    half: bool = False,
    ending: str | None = None,
) -> None:
    """Write a picture and read it back; alpha unassociated, no colour-space data, metadata under ``nmaptool:``.

    Parameters
    ----------
    path : Path
        Where to write.
    pixels : (H, W, C) uint8, uint16 or float32
    channels : tuple of str
        One name per channel.
    attributes : mapping
        Metadata; keys without prefix.
    half : bool
        Store float32 as half.
    ending : str, optional
        Format by its ending. Default: the path's own.

    Raises
    ------
    OutputError
        If writing fails or what is on disk is not what was written.
    """
    rows, cols, count = pixels.shape
    kind = (ending or path.suffix).lower()
    stored = "half" if half else {"u1": "uint8", "u2": "uint16", "f4": "float"}[pixels.dtype.str[1:]]
    spec = oiio.ImageSpec(cols, rows, count, stored)
    spec.channelnames = channels
    spec.alpha_channel = channels.index("A") if "A" in channels else -1
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("oiio:ColorSpace", "data")
    spec.attribute("Software", "nmaptool")
    spec.attribute("compression", "zip")
    if kind == ".png":
        spec.attribute("png:compressionLevel", 5)
    if kind in (".tif", ".tiff"):
        spec.attribute("ImageDescription", "\n".join(f"{PREFIX}{k}={v}" for k, v in attributes.items()))
    else:
        for key, value in attributes.items():
            spec.attribute(PREFIX + key, value)
    sink = oiio.ImageOutput.create(f"picture{kind}")
    good = sink is not None and sink.open(str(path), spec) and sink.write_image(np.ascontiguousarray(pixels))
    reason = "" if good else _error_text(sink if sink is not None else oiio)
    if sink is not None:
        good = bool(sink.close()) and good
    if good:
        good = _same_on_disk(path, pixels, half)  # the PNG writer calls a full disk a success
    if not good:
        raise OutputError(f"{path}: cannot be written ({reason or 'is the disk full?'})")


def _same_on_disk(path: Path, pixels: NDArray[Any], half: bool) -> bool:
    try:
        back = read_image(path, max_megapixels=float("inf")).pixels
    except InputError:
        return False
    expected = pixels.astype(np.float16).astype(np.float32) if half else pixels
    return bool(back.shape == expected.shape and np.array_equal(back, expected, equal_nan=expected.dtype.kind == "f"))

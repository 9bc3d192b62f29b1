"""Normal maps and grey control maps as files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.pictures.reader import read_image
from nmaptool.io.pictures.writer import Picture, write_pictures
from nmaptool.io.replace import named, written_beside
from nmaptool.maps import codec
from nmaptool.maps.decoding import decode_normal_map
from nmaptool.options import Bits, ReadOptions, WriteOptions
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import RasterImage

# what each ending can hold, the default first
_BITS: dict[str, tuple[Bits, ...]] = {
    ".png": ("16", "8"),
    ".exr": ("float", "half"),
    ".tif": ("16", "8", "float"),
    ".tiff": ("16", "8", "float"),
}
WRITE_ENDINGS = tuple(_BITS)


def split_layer(text: str) -> tuple[Path, str | None]:
    """``maps.exr:detail`` as a path and a layer; a file of that very name wins.

    >>> split_layer("maps.exr:detail")[1]
    'detail'
    """
    path = Path(text)
    head, mark, layer = text.rpartition(":")
    if mark and layer and Path(head).suffix and not os.path.exists(text):  # noqa: PTH110 - never raises
        return Path(head), layer
    return path, None


def read_raster(path: str | Path, options: ReadOptions | None = None) -> RasterImage:
    """Read a picture without decoding it, for `nmaptool.inspect_map` or `nmaptool.decode_normal_map`.

    Parameters
    ----------
    path : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    options : ReadOptions, optional
        Only ``layer`` and ``max_megapixels`` are used.

    Returns
    -------
    RasterImage
        Codes or floats as stored.

    Raises
    ------
    InputError, LimitError
        As `nmaptool.io.pictures.reader.read_image`.

    Examples
    --------
    >>> nm.read_raster("samples/leaf_mask.png")
    <RasterImage samples/leaf_mask.png: 224 x 224 px, pitch unknown, channels Y, 8-bit codes>
    """
    options = options or ReadOptions()
    file, layer = split_layer(str(path))
    return read_image(file, layer or options.layer, options.max_megapixels)


def read_normal_map(
    path: str | Path, options: ReadOptions | None = None, *, like: NormalMap | None = None
) -> NormalMap:
    """Read a normal map: PNG, EXR, TIFF, JPEG or BMP.

    Parameters
    ----------
    path : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    options : ReadOptions, optional
    like : NormalMap, optional
        The original that this map belongs to. Green points the same way, unless the options or the file say otherwise:
        the curl of a detail map or of a smooth background is too small to tell.

    Returns
    -------
    NormalMap
        Unit normals in eye space; ``decoding`` says what was decided.

    Raises
    ------
    InputError
        If the file cannot be read or is no normal map.
    LimitError
        If it is larger than ``options.max_megapixels``.

    Examples
    --------
    >>> nm.read_normal_map("samples/medal_original.png")
    <NormalMap samples/medal_original.png: 248 x 248 px, pitch unknown, 72% covered>
    """
    options = options or ReadOptions()
    image = read_raster(path, options)
    return decode_normal_map(image, options_like(image, options, like))


def options_like(image: RasterImage, options: ReadOptions, like: NormalMap | None) -> ReadOptions:
    """The options with green as in ``like``, unless they or the file itself say which way it points."""
    if like is None or options.green != "auto" or image.attributes.get("green") in ("up", "down"):
        return options
    return replace(options, green="down" if like.decoding.green == "down" else "up")


def read_grey(path: str | Path, *, max_megapixels: float = 270.0) -> Float32:
    """Read a grey control picture: a mask, or a map of weights.

    Integer codes become 0 to 1; floats stay as they are. A picture whose three colours are equal counts as grey. If
    only alpha varies, alpha is used.

    Parameters
    ----------
    path : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    max_megapixels : float
        Refuse a larger picture.

    Returns
    -------
    (H, W) float32

    Raises
    ------
    InputError
        If it cannot be read, is coloured, or holds NaN or infinite values.

    Examples
    --------
    >>> mask = nm.read_grey("samples/leaf_mask.png")
    >>> mask.dtype, float(mask.min()), float(mask.max())
    (dtype('float32'), 0.0, 1.0)
    """
    image = read_raster(path, ReadOptions(max_megapixels=max_megapixels))
    colors = [i for i, name in enumerate(image.channels) if name != "A"] or [0]  # alpha alone is a mask, too
    grey = image.pixels[..., colors[0]]
    tolerance = 8 if image.lossy else 0
    for other in colors[1:]:
        difference = np.abs(image.pixels[..., other].astype(np.float64) - grey)
        if not np.all(difference <= tolerance):
            raise InputError(
                f"{image.name}: is a colour picture; a mask or weight map must be grey, or alpha on a single colour"
            )
    values = grey.astype(np.float32) / np.float32(image.max_code)
    if not np.isfinite(values).all():
        raise InputError(f"{image.name}: holds NaN or infinite values; repair them")
    alpha = image.alpha
    if alpha is not None and values.min() == values.max() and alpha.min() < alpha.max():
        return alpha
    return values


def _bits(ending: str, options: WriteOptions) -> Bits:
    return _BITS[ending][0] if options.bits == "auto" else options.bits


def bits_of(path: Path, options: WriteOptions) -> Bits:
    """The bits that a normal map is written with there: "8", "16", "half" or "float"."""
    check_ending(path, options)
    return _bits(path.suffix.lower(), options)


def check_ending(path: Path, options: WriteOptions) -> None:
    """Refuse an ending that no normal map is written with, or bits that it cannot hold.

    Raises
    ------
    UsageError
    """
    ending = path.suffix.lower()
    if ending not in WRITE_ENDINGS:
        found = f"ends in {path.suffix}" if path.suffix else "has no ending"
        raise UsageError(f"{path}: {found}; normal maps are written as {', '.join(WRITE_ENDINGS)}")
    offered = _BITS[ending]
    if options.bits not in ("auto", *offered):
        raise UsageError(f"{path}: --bits {options.bits} is not offered for {ending}; use {' or '.join(offered)}")


def write_normal_map(
    path: str | Path,
    normal_map: NormalMap,
    options: WriteOptions | None = None,
    *,
    attributes: Mapping[str, str] | None = None,
    overwrite: bool = False,
) -> None:
    """Write a normal map; coverage travels as unassociated alpha, the convention and pitch as metadata.

    Parameters
    ----------
    path : str or Path
        ``.png``, ``.tif`` (integer codes) or ``.exr`` (signed floats).
    normal_map : NormalMap
    options : WriteOptions, optional
    attributes : mapping, optional
        More metadata, such as the recipe.
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the ending or the bits are not offered.
    OutputError
        If it cannot be written, or exists.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.write_normal_map("flat.png", nm.NormalMap.from_array(flat, pitch_mm=0.5))
    >>> nm.read_normal_map("flat.png", nm.ReadOptions(background_color="none"))
    <NormalMap flat.png: 48 x 32 px, 0.5 mm per px, 100% covered>
    """
    target, options = Path(path), options or WriteOptions()
    check_ending(target, options)
    picture = map_picture(normal_map, target.suffix.lower(), options)
    picture = replace(picture, attributes={**picture.attributes, **(attributes or {})})
    with written_beside([target], overwrite) as (beside,), named(target, beside):
        write_pictures(beside, [picture])


def map_picture(normal_map: NormalMap, ending: str, options: WriteOptions) -> Picture:
    """A normal map as a file of that ending holds it."""
    bits = _bits(ending, options)
    depth = 32 if bits in ("half", "float") else int(bits)
    zero_code = "127.5" if options.write_zero_code == "auto" else options.write_zero_code
    return normal_picture(normal_map, depth, half=bits == "half", green=options.write_green, zero_code=zero_code)


def normal_picture(
    normal_map: NormalMap, bits: int, *, half: bool = False, name: str = "", green: str = "up", zero_code: str = "127.5"
) -> Picture:
    """A normal map as a file holds it: codes of 8 or 16 bits, or signed floats (32); its coverage as alpha."""
    covered = bool((normal_map.coverage < 1).any())
    channels = ("R", "G", "B", "A") if covered else ("R", "G", "B")
    attributes = {"version": __version__, "kind": "normal", "green": green}
    if normal_map.frame.pitch_mm is not None:
        attributes["pitch_mm"] = repr(normal_map.frame.pitch_mm)
    normals = normal_map.normals
    if green == "down":
        normals = normals * np.array([1, -1, 1], np.float32) + np.float32(0)  # + 0: flat gives 0, not -0
    colors: NDArray[Any]
    alpha: NDArray[Any]
    if bits == 32:
        attributes["encoding"] = "signed"
        colors, alpha = normals, normal_map.coverage
    else:
        attributes["zero_code"] = zero_code
        colors = codec.encode_codes(normals, bits, zero_code)
        alpha = codec.grey_codes(normal_map.coverage, bits)
    pixels = np.dstack([colors, alpha]) if covered else colors
    return Picture(pixels, channels, attributes, name=name, half=half)

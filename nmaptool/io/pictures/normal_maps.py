"""Read normal maps and grey control maps, and make pictures of normal maps to write."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.reader import read_image
from nmaptool.io.pictures.writer import Picture
from nmaptool.maps import codec
from nmaptool.maps.decoding import decode_normal_map
from nmaptool.options import ReadOptions
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage


def split_layer(text: str) -> tuple[Path, str | None]:
    """Split ``maps.exr:detail`` into a path and a layer; a file with exactly that name takes precedence.

    >>> split_layer("maps.exr:detail")[1]
    'detail'
    """
    path = Path(text)
    head, mark, layer = text.rpartition(":")
    if mark and layer and Path(head).suffix and not os.path.exists(text):  # noqa: PTH110 - never raises
        return Path(head), layer
    return path, None


def read_raster(path: str | Path, options: ReadOptions | None = None, *, holds: Holds = "normals") -> RasterImage:
    """Read a picture as stored, for `inspect_map`, `decode_normal_map` or `depth_to_normals`.

    Parameters
    ----------
    path : str or Path
        ``FILE``, or ``FILE.exr:layer`` or ``FILE.npz:array``.
    options : ReadOptions, optional
        ``layer`` and ``max_megapixels`` are used.
    holds : str
        What the picture is read for, "normals", "depth" or "grey" (a mask): in a file with several layers, the one
        with such a name is read if the options name none.

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
    return read_image(file, layer or options.layer, options.max_megapixels, holds)


def read_normal_map(
    path: str | Path, options: ReadOptions | None = None, *, like: NormalMap | None = None
) -> NormalMap:
    """Read a normal map from a picture or array file.

    Parameters
    ----------
    path : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    options : ReadOptions, optional
    like : NormalMap, optional
        The original to which this map belongs. It sets the direction of green unless the options or the file state it,
        because the curl of a detail map or a smooth background shows it poorly.

    Returns
    -------
    NormalMap
        Unit normals in eye space; ``decoding`` states what was detected.

    Raises
    ------
    InputError
        If the file cannot be read or is not a normal map.
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


class HasDecoding(Protocol):
    """A normal map, or a store of one."""

    @property
    def decoding(self) -> Decoding: ...  # noqa: D102


def options_like(image: RasterImage, options: ReadOptions, like: HasDecoding | None) -> ReadOptions:
    """Return the options with green as in ``like``, unless they or the file state its direction."""
    if like is None or options.green != "auto" or image.attributes.get("green") in ("up", "down"):
        return options
    return replace(options, green="down" if like.decoding.green == "down" else "up")


def read_grey(path: str | Path, *, max_megapixels: float = 270.0, upright: bool = False) -> Float32:
    """Read a grey control picture: a mask, or a map of weights.

    Integer codes become 0..1; floats are not changed. Integer arrays of 0 and 1 are masks, whole numbers from 0 to 255
    are codes. A picture whose colour channels are equal counts as grey. If
    only alpha varies, alpha is returned.

    Parameters
    ----------
    path : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    max_megapixels : float
        Refuse a larger picture.
    upright : bool
        Turn it by its EXIF orientation.

    Returns
    -------
    (H, W) float32

    Raises
    ------
    InputError
        If it cannot be read, is coloured, holds only the codes 0 and 1, or holds NaN or infinite values.

    Examples
    --------
    >>> mask = nm.read_grey("samples/leaf_mask.png")
    >>> mask.dtype, float(mask.min()), float(mask.max())
    (dtype('float32'), 0.0, 1.0)
    """
    image = read_raster(path, ReadOptions(max_megapixels=max_megapixels), holds="grey")
    image = image.upright() if upright else image
    grey = grey_channel(image)
    if not image.is_float and not image.lossy and grey.max() == 1:
        raise only_zero_and_one(image)
    values = grey_values(image, grey, image.max_code)
    alpha = image.alpha
    if alpha is not None and values.min() == values.max() and alpha.min() < alpha.max():
        return alpha
    return values


def grey_channel(image: RasterImage) -> NDArray[Any]:
    """(H, W): the stored values of a picture whose colour channels are equal.

    Raises
    ------
    InputError
        If they are not.
    """
    colors = [i for i, name in enumerate(image.channels) if name != "A"] or [0]  # alpha alone is also a mask
    grey: NDArray[Any] = image.pixels[..., colors[0]]
    tolerance = 8 if image.lossy else 0
    for other in colors[1:]:
        difference = np.abs(image.pixels[..., other].astype(np.float64) - grey)
        if not np.all(difference <= tolerance):
            raise InputError(
                f"{image.name}: is a colour picture; a mask or weight map must be grey, or alpha on a single colour"
            )
    return grey


def grey_values(image: RasterImage, grey: NDArray[Any], white: int) -> Float32:
    """(H, W) float32: stored values as shares of the value of white.

    Raises
    ------
    InputError
        If some are NaN or infinite.
    """
    values: Float32 = grey.astype(np.float32) / np.float32(white)
    if not np.isfinite(values).all():
        raise InputError(f"{image.name}: holds NaN or infinite values; repair them")
    return values


def only_zero_and_one(image: RasterImage) -> InputError:
    """The error about a mask whose white is code 1."""
    white = image.max_code
    return InputError(f"{image.name}: holds only the codes 0 and 1 of {white}; save white as {white}")


def map_attributes(bits: int, *, green: str, zero_code: str) -> dict[str, str]:
    """The metadata of a normal map that is written with these conventions."""
    coding = {"encoding": "signed"} if bits == 32 else {"zero_code": zero_code}
    return {"version": __version__, "kind": "normal", "green": green, **coding}


def normal_picture(
    normal_map: NormalMap, bits: int, *, half: bool = False, name: str = "", green: str = "up", zero_code: str = "127.5"
) -> Picture:
    """Return the picture of a normal map: codes of 8 or 16 bits, or signed floats (32), with coverage as alpha."""
    covered = bool((normal_map.coverage < 1).any())
    channels = ("R", "G", "B", "A") if covered else ("R", "G", "B")
    attributes = map_attributes(bits, green=green, zero_code=zero_code)
    if normal_map.frame.pitch_mm is not None:
        attributes["pitch_mm"] = repr(normal_map.frame.pitch_mm)
    coverage = normal_map.coverage if covered else None
    pixels = codec.encode_map(normal_map.normals, coverage, bits, green=green, zero_code=zero_code)
    return Picture(pixels, channels, attributes, name=name, half=half)

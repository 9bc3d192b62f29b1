"""Convert arguments, which may be plain arrays, to the values that features compute with."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.height import Height
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import RasterImage
from nmaptool.types.plain_arrays import as_numbers, is_array
from nmaptool.types.relief import Relief

# a normal map, or (H, W, 3) floats of any type
NormalsLike: TypeAlias = NormalMap | NDArray[np.floating[Any]]
# (H, W) of any type: False and True, or 0 to 1
MaskLike: TypeAlias = NDArray[np.bool_] | NDArray[np.floating[Any]]
# (H, W) floats of any type
FloatsLike: TypeAlias = NDArray[np.floating[Any]]
# a picture, or (H, W) or (H, W, channels) floats or codes
RasterLike: TypeAlias = RasterImage | NDArray[np.floating[Any]] | NDArray[np.uint8] | NDArray[np.uint16]

_CHANNELS = {1: ("Y",), 2: ("R", "G"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}


def as_normal_map(value: Any, what: str = "the map", mask: Float32 | None = None) -> NormalMap:
    """Return a normal map unchanged, or make one from an array of normals.

    Parameters
    ----------
    value : NormalMap or (H, W, 3) float
    what : str
        Name for messages, such as "the original".
    mask : (H, W) float32, optional
        An array holds normals where this is above 0. Ignored for a NormalMap, which has its own coverage.

    Raises
    ------
    InputError
        See `nmaptool.NormalMap.from_array`.
    UsageError
        If the value is neither, such as a path.
    """
    if isinstance(value, NormalMap):
        return value
    if not is_array(value):
        raise UsageError(
            f"{what} must be a NormalMap, found {type(value).__name__}; read one with read_normal_map, or give an "
            "array of normals (H, W, 3)"
        )
    name = what.removeprefix("the ").removesuffix(" map")
    return NormalMap.from_array(value, None if mask is None else mask > 0, name=name)


def as_raster(value: Any, what: str = "the picture") -> RasterImage:
    """Return a picture unchanged, or make one from an array of grey values or colours.

    Parameters
    ----------
    value : RasterImage or (H, W) or (H, W, 1 to 4) uint8, uint16 or float
        By number of channels: grey; red and green; red, green and blue; red, green, blue and alpha.
    what : str
        Name for messages.

    Raises
    ------
    InputError, UsageError
        If the array has another shape or type, or the value is neither a picture nor an array.
    """
    if isinstance(value, RasterImage):
        return value
    if not is_array(value):
        raise UsageError(
            f"{what} must be a RasterImage, found {type(value).__name__}; read one with read_raster, or give an array"
        )
    pixels = as_numbers(value, what)
    bits = 8 * min(pixels.dtype.itemsize, 4)
    if pixels.dtype.kind == "f":
        with np.errstate(over="ignore"):
            pixels = pixels.astype(np.float32, copy=False)
    elif pixels.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{what} is {pixels.dtype}; expected floats, or codes as uint8 or uint16")
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    if pixels.ndim != 3 or pixels.shape[2] not in _CHANNELS or not pixels.size:
        raise InputError(f"{what} is {np.shape(value)}; expected (H, W) or (H, W, channels) with 1 to 4 channels")
    return RasterImage(pixels, _CHANNELS[pixels.shape[2]], what.removeprefix("the "), bits)


def as_height(value: Any, what: str = "the height field") -> Height:
    """Return a height field unchanged, or that of a relief.

    Raises
    ------
    UsageError
        If the value is neither, such as an array, which has no pixel size.
    """
    if isinstance(value, Relief):
        return value.height
    if not isinstance(value, Height):
        raise UsageError(
            f"{what} must be a Height or a Relief, found {type(value).__name__}; read one with read_height"
        )
    return value

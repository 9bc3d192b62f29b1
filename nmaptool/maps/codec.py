"""Convert stored codes to vectors and back: only this module handles signs, bit depth, zero code and channel order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import UsageError
from nmaptool.core.parallel import for_each_band
from nmaptool.core.vectors import make_flat
from nmaptool.maps.zero_code import flat_codes, has_color, zero_and_scale
from nmaptool.types.picture import RasterImage

_SWIZZLE = re.compile(r"([+-]?)([rgba])")
# the number of alpha in a swizzle
ALPHA = 3
_ROWS_AT_ONCE = 64
_CODES_AT_ONCE = 1 << 17

Signs = tuple[int, int, int]
Swizzle = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Coding:
    """How a file encodes the components of vectors.

    Attributes
    ----------
    max_code : int
        Largest integer code, 255 or 65535; 1 for floats.
    zero_code : str
        For integers, see `zero_and_scale`.
    signed : bool
        Whether floats hold n itself, not (n + 1)/2.
    is_float : bool
    """

    max_code: int = 255
    zero_code: str = "127.5"
    signed: bool = False
    is_float: bool = False

    @property
    def step(self) -> float:
        """Distance between two neighbouring codes, in units of a component; 0 for floats."""
        return 0.0 if self.is_float else 1 / zero_and_scale(self.zero_code, self.max_code)[1]


def decode_map(codes: NDArray[Any], coding: Coding) -> Float32:
    """Decode stored values to vectors, with the channel order and signs of the file.

    Parameters
    ----------
    codes : (..., 3) uint8, uint16 or float
    coding : Coding

    Returns
    -------
    (..., 3) float32
        A new array, not normalised. Integers give values in [-1, 1]; the exact flat code gives exactly (0, 0, 1).
    """
    if not coding.is_float:
        return decode_codes(codes, coding.zero_code)
    vectors: Float32 = codes.astype(np.float32)
    return vectors if coding.signed else vectors * 2 - 1


def decode_color(color: Sequence[float], coding: Coding) -> Float32:
    """(3,) float32: the vector of one stored colour, which may lie between two codes."""
    if coding.is_float:
        return decode_map(np.array(color), coding)
    zero, scale = zero_and_scale(coding.zero_code, coding.max_code)
    return ((np.array(color) - zero) / scale).astype(np.float32)


def encode_map(
    normals: Float32,
    coverage: Float32 | None,
    bits: int,
    *,
    green: str = "up",
    zero_code: str = "127.5",
) -> NDArray[Any]:
    """Encode a normal map as the pixels of a file.

    Parameters
    ----------
    normals : (H, W, 3) float32
        Unit vectors in eye space.
    coverage : (H, W) float32 or None
        For the alpha channel; None writes none.
    bits : int
        8 or 16 for integer codes, 32 for signed floats.
    green : str
        Direction of the file's green channel, "up" or "down".
    zero_code : str
        For integer codes, see `zero_and_scale`.

    Returns
    -------
    (H, W, 3 or 4) uint8, uint16 or float32
    """
    if green == "down":
        normals = apply_signs(normals, signs_of(green=green))
    colors = normals if bits == 32 else encode_codes(normals, bits, zero_code)
    return colors if coverage is None else np.dstack([colors, encode_grey(coverage, bits)])


def signs_of(swizzle: Swizzle = ((0, 1), (1, 1), (2, 1)), green: str = "up") -> Signs:
    """Signs that convert stored vectors, with channels in the order x, y, z, to eye space and back.

    >>> signs_of(parse_swizzle("-g,r,b"), green="down")
    (-1, -1, 1)
    """
    x, y, z = (sign for _, sign in swizzle)
    return x, -y if green == "down" else y, z


def apply_signs(vectors: Float32, signs: Signs, out: Float32 | None = None) -> Float32:
    """Multiply vectors by the signs of their components; a zero stays 0, never -0.

    Parameters
    ----------
    vectors : (..., 3) float32
    signs : tuple of int
        1 or -1 for x, y and z.
    out : (..., 3) float32, optional
        Where to put the result, such as the vectors themselves. Default: a new array.
    """
    out = np.multiply(vectors, np.array(signs, np.float32), out=out)
    out += np.float32(0)  # -0 + 0 is 0
    return out


def stored_shares(pixels: NDArray[Any], signed: bool) -> Float32:
    """(..., 3) float32: stored colours as shares (n + 1)/2 of the largest code; NaN and infinity become 0.5 (n = 0).

    Parameters
    ----------
    pixels : (..., 3 or more) uint8, uint16 or float32
        Further channels are ignored.
    signed : bool
        Whether floats hold n itself.
    """
    color = pixels[..., :3]
    if pixels.dtype != np.float32:
        return color.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    finite = np.where(np.isfinite(color), color, np.float32(0 if signed else 0.5))
    return np.asarray(encode_shares(finite) if signed else finite, np.float32)


def decode_shares(shares: NDArray[Any]) -> NDArray[Any]:
    """Convert shares (n + 1)/2 to components n; the type is kept."""
    return 2 * shares - 1


def encode_shares(vectors: NDArray[Any]) -> NDArray[Any]:
    """Convert components n to shares (n + 1)/2; the type is kept."""
    return (vectors + 1) / 2


def narrowed(image: RasterImage) -> RasterImage:
    """Return the picture as 8-bit codes if that is all it holds, widened to 16 bits or divided by 255 into floats.

    Zero code, rounding and backgrounds are then those of the original 8-bit picture.
    """
    pixels = image.pixels
    if pixels.dtype == np.uint16:
        for factor in (257, 256):
            # a step that is odd visits all columns and channels
            if not np.any(pixels.ravel()[:: pixels.size // 4096 | 1] % factor) and not np.any(pixels % factor):
                return replace(image, pixels=(pixels // factor).astype(np.uint8))
    elif pixels.dtype == np.float32 and np.isfinite(pixels).all() and pixels.min() >= 0 and 0 < pixels.max() <= 1:
        codes = pixels * np.float32(255)
        whole = np.rint(codes)
        # half floats hold k/255 to about 0.06 of a code
        if len(np.unique(whole)) > 2 and np.all(np.abs(codes - whole) < (2e-3 if image.bits == 32 else 0.07)):
            return replace(image, pixels=whole.astype(np.uint8))
    return image


def decode_codes(rgb: NDArray[Any], zero_code: str) -> Float32:
    """Convert integer codes to vectors in [-1, 1]; the exact flat code becomes exactly (0, 0, 1).

    Parameters
    ----------
    rgb : (H, W, 3) uint8 or uint16
    zero_code : str
        See `zero_and_scale`. With "127.5", n = 2v/M - 1 (M the largest code).

    Returns
    -------
    (H, W, 3) float32, not normalised
    """
    max_code = int(np.iinfo(rgb.dtype).max)
    zero, scale = zero_and_scale(zero_code, max_code)
    table = ((np.arange(max_code + 1, dtype=np.float64) - zero) / scale).clip(-1, 1).astype(np.float32)
    vectors = np.empty(rgb.shape, np.float32)
    flat = flat_codes(max_code)["127" if zero_code == "127" else "128"]

    def look_up(band: slice) -> None:
        codes = rgb[band]
        np.take(table, codes, out=vectors[band], mode="clip")
        make_flat(vectors[band], has_color(codes, flat))

    for_each_band(len(rgb), max(1, _CODES_AT_ONCE // max(1, rgb[0].size)), look_up)
    return vectors


def encode_codes(vectors: Float32, bits: int, zero_code: str = "127.5") -> NDArray[Any]:
    """Convert vectors in [-1, 1] to rounded integer codes: with zero in the middle, v = floor((n + 1)/2 M + .5).

    Parameters
    ----------
    vectors : (H, W, 3) float32
    bits : int
        8 or 16.
    zero_code : str
        See `zero_and_scale`.

    Returns
    -------
    (H, W, 3) uint8 or uint16
    """
    max_code = (1 << bits) - 1
    zero, scale = zero_and_scale(zero_code, max_code)
    out = np.empty(vectors.shape, np.uint8 if bits == 8 else np.uint16)
    for row in range(0, len(vectors), _ROWS_AT_ONCE):  # in bands, because float64 copies are large
        rows = slice(row, row + _ROWS_AT_ONCE)
        codes = np.floor(vectors[rows].astype(np.float64) * scale + (zero + 0.5))
        out[rows] = codes.clip(0, max_code)
    return out


def encode_grey(values: Float32, bits: int) -> NDArray[Any]:
    """Convert (H, W) values in [0, 1] to codes of 8 or 16 bits; unchanged for floats (32)."""
    return values if bits == 32 else grey_codes(values, bits)


def grey_codes(values: NDArray[np.floating], bits: int) -> NDArray[Any]:
    """Convert (H, W) values in [0, 1] to rounded integer codes of 8 or 16 bits."""
    top = (1 << bits) - 1
    return np.floor(values.astype(np.float64) * top + 0.5).astype(np.uint8 if bits == 8 else np.uint16)


def format_swizzle(swizzle: Swizzle) -> str:
    """The text that `parse_swizzle` reads, in its shortest form.

    >>> format_swizzle(((1, -1), (0, 1), (2, 1)))
    '-g,r,b'
    """
    return ",".join(("-" if sign < 0 else "") + "rgba"[channel] for channel, sign in swizzle)


def parse_swizzle(text: str) -> Swizzle:
    """Read "-g,r,b" as ((1, -1), (0, 1), (2, 1)): (channel, sign) of x, y and z.

    Raises
    ------
    UsageError
        If the text is not three different channels of r, g, b, a, each with an optional sign.
    """
    parts = [_SWIZZLE.fullmatch(part.strip().lower()) for part in text.split(",")]
    found = [part for part in parts if part is not None]
    if len(parts) != 3 or len(found) != 3 or len({part.group(2) for part in found}) != 3:
        raise UsageError(f"`swizzle={text!r}`: give the channels of x, y and z, such as r,g,b or -g,r,b")
    return tuple(("rgba".index(part.group(2)), -1 if part.group(1) == "-" else 1) for part in found)

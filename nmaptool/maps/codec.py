"""Stored codes to vectors and back: sign, bit depth, zero code and channel order are settled here and nowhere else."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import UsageError
from nmaptool.core.parallel import for_each_band
from nmaptool.types.picture import RasterImage

ZERO_CODES = ("127", "127.5", "128")
_SWIZZLE = re.compile(r"([+-]?)([rgb])")
# A flat code is taken for the file's own zero only where it stands out as a spike: fields that merely pass through
# flat hold its three neighbours about as often.
_SPIKE = 4
_SPIKE_PIXELS = 64
_ROWS_AT_ONCE = 64
_CODES_AT_ONCE = 1 << 17


def narrowed(image: RasterImage) -> RasterImage:
    """The picture as 8-bit codes where that is all it holds: widened to 16 bits, or divided by 255 into floats.

    Zero code, rounding and backgrounds are then those of the 8-bit picture it was.
    """
    pixels = image.pixels
    if pixels.dtype == np.uint16:
        for factor in (257, 256):
            if not np.any(pixels.ravel()[:: max(1, pixels.size // 4096)] % factor) and not np.any(pixels % factor):
                return replace(image, pixels=(pixels // factor).astype(np.uint8))
    elif pixels.dtype == np.float32 and np.isfinite(pixels).all() and pixels.min() >= 0 and 0 < pixels.max() <= 1:
        codes = pixels * np.float32(255)
        whole = np.rint(codes)
        # half floats hold k/255 to about 0.06 of a code
        if len(np.unique(whole)) > 2 and np.all(np.abs(codes - whole) < (2e-3 if image.bits == 32 else 0.07)):
            return replace(image, pixels=whole.astype(np.uint8))
    return image


def zero_and_scale(zero_code: str, max_code: int) -> tuple[float, float]:
    """Code that means 0 and codes per unit, so that n = (v - zero) / scale.

    Parameters
    ----------
    zero_code : str
        "127.5" (the middle), "128" (upper neighbour) or "127" (lower neighbour: a truncating writer), in 8-bit terms.
    max_code : int
        255 or 65535.

    Examples
    --------
    >>> zero_and_scale("128", 65535)
    (32768.0, 32767.0)
    """
    middle = max_code / 2
    if zero_code == "128":
        return middle + 0.5, middle - 0.5
    if zero_code == "127":
        return middle - 0.5, middle
    return middle, middle


def flat_codes(max_code: int) -> dict[str, tuple[int, int, int]]:
    """Codes that writers store for the flat normal, by the zero code they imply."""
    middle = (max_code + 1) // 2
    return {"128": (middle, middle, max_code), "127": (middle - 1, middle - 1, max_code)}


def detect_zero_code(rgb: NDArray[Any]) -> str | None:
    """Zero code told by the exact flat code, or None where no flat code stands out.

    Parameters
    ----------
    rgb : (H, W, 3) uint8 or uint16

    Returns
    -------
    "128", "127" or None
    """
    max_code = int(np.iinfo(rgb.dtype).max)
    middle = (max_code + 1) // 2
    # a truncating writer stores 254 or 255 for nz = 1
    candidates = rgb[rgb[..., 2] >= max_code - 1][:, :2]
    near = candidates[((candidates == middle) | (candidates == middle - 1)).all(axis=1)]
    counts = np.bincount((near[:, 0] == middle) * 2 + (near[:, 1] == middle), minlength=4)
    order = np.sort(counts)
    if order[-1] < _SPIKE_PIXELS or order[-1] < _SPIKE * order[-2]:
        return None
    winner = int(np.argmax(counts))
    return {3: "128", 0: "127"}.get(winner)


def decode_codes(rgb: NDArray[Any], zero_code: str) -> Float32:
    """Integer codes to vectors in [-1, 1]; the exact flat code becomes exactly (0, 0, 1).

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
    x, y, z = flat_codes(max_code)["127" if zero_code == "127" else "128"]

    def look_up(band: slice) -> None:
        codes = rgb[band]
        np.take(table, codes, out=vectors[band], mode="clip")
        vectors[band][(codes[..., 0] == x) & (codes[..., 1] == y) & (codes[..., 2] == z)] = (0, 0, 1)

    for_each_band(len(rgb), max(1, _CODES_AT_ONCE // max(1, rgb[0].size)), look_up)
    return vectors


def encode_codes(vectors: Float32, bits: int, zero_code: str = "127.5") -> NDArray[Any]:
    """Vectors in [-1, 1] to integer codes, rounded: with the zero in the middle, v = floor((n + 1)/2 M + .5).

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
    for row in range(0, len(vectors), _ROWS_AT_ONCE):  # in float64, which would be large all at once
        rows = slice(row, row + _ROWS_AT_ONCE)
        codes = np.floor(vectors[rows].astype(np.float64) * scale + (zero + 0.5))
        out[rows] = codes.clip(0, max_code)
    return out


def grey_codes(values: Float32, bits: int) -> NDArray[Any]:
    """(H, W) values in [0, 1] as integer codes of 8 or 16 bits, rounded."""
    top = (1 << bits) - 1
    return np.floor(values.astype(np.float64) * top + 0.5).astype(np.uint8 if bits == 8 else np.uint16)


def format_swizzle(swizzle: tuple[tuple[int, int], ...]) -> str:
    """The text that `parse_swizzle` reads, in its plainest form.

    >>> format_swizzle(((1, -1), (0, 1), (2, 1)))
    '-g,r,b'
    """
    return ",".join(("-" if sign < 0 else "") + "rgb"[channel] for channel, sign in swizzle)


def parse_swizzle(text: str) -> tuple[tuple[int, int], ...]:
    """Read "-g,r,b" as ((1, -1), (0, 1), (2, 1)): (channel, sign) of x, y and z.

    Raises
    ------
    UsageError
        If it is not three different channels out of r, g, b, each with an optional sign.
    """
    parts = [_SWIZZLE.fullmatch(part.strip().lower()) for part in text.split(",")]
    found = [part for part in parts if part is not None]
    if len(parts) != 3 or len(found) != 3 or {part.group(2) for part in found} != {"r", "g", "b"}:
        raise UsageError(f"--swizzle {text!r}: give the channels of x, y and z, such as r,g,b or -g,r,b")
    return tuple(("rgb".index(part.group(2)), -1 if part.group(1) == "-" else 1) for part in found)

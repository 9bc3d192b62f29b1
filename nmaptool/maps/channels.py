"""The channels of a raw picture that hold x, y and z, and how they encode vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, UsageError
from nmaptool.maps import codec
from nmaptool.maps.layouts import arranged, straightened
from nmaptool.maps.two_channel import as_three_channels, find_components, is_unsigned_pair, pair_of_channels
from nmaptool.maps.zero_code import ZERO_CODES, detect_zero_code
from nmaptool.options import ReadOptions
from nmaptool.options.presets import NORMAL_PRESETS
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import counted

_ROWS_AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class Channels:
    """The stored values of x, y and z, and how they encode vectors.

    Attributes
    ----------
    image : RasterImage
        The picture with three colour channels, as 8-bit codes if that is all it holds.
    xyz : (H, W, 3) uint8, uint16 or float32
        Its colour channels in the order x, y, z, all finite.
    swizzle : tuple of (channel, sign)
        See `codec.parse_swizzle`; channels of ``image``.
    asked : tuple of (channel, sign)
        The same in channels of the file, which may include alpha.
    coding : Coding
    components, components_from, zero_code_from : str
        As in `Decoding`.
    """

    image: RasterImage
    xyz: NDArray[Any]
    swizzle: codec.Swizzle
    asked: codec.Swizzle
    coding: codec.Coding
    components: str
    components_from: str
    zero_code_from: str

    @property
    def order(self) -> tuple[int, ...]:
        """Which of the channels R, G, B feeds x, y and z."""
        return _order(self.swizzle)

    @property
    def zero_code(self) -> str:
        """The stored value that means 0, for reports."""
        if self.coding.is_float:
            return "0" if self.coding.signed else "0.5"
        return self.coding.zero_code

    @property
    def encoding(self) -> str:
        """``signed`` or ``unsigned``, for reports."""
        return "signed" if self.coding.signed else "unsigned"


def find_channels(image: RasterImage, options: ReadOptions) -> Channels:
    """Find the channels of a picture that hold x, y and z, and how they encode vectors.

    Raises
    ------
    InputError, UsageError
        As `nmaptool.decode_normal_map`.
    """
    asked = codec.parse_swizzle("r,g,b" if options.swizzle is None else options.swizzle)
    from_preset = options.from_ != "auto" and options.swizzle == NORMAL_PRESETS[options.from_].swizzle
    asked_by = f"`from_={options.from_!r}`" if from_preset else f"`swizzle={options.swizzle!r}`"
    image, swizzle = arranged(straightened(image, options.curve), asked, options.components, asked_by)
    order = _order(swizzle)
    if options.encoding != "signed" and options.curve == "none":
        image = codec.narrowed(image)
    components, components_from = find_components(image, options.components, order)
    if components == "xy" and swizzle[2][1] < 0:
        if not from_preset:
            raise UsageError(f"{asked_by}: z is computed from x and y and is never negative; remove its minus sign")
        swizzle, asked = ((*one[:2], (one[2][0], 1)) for one in (swizzle, asked))
    encoding: str = options.encoding if options.curve == "none" else "unsigned"
    if components != "xyz":
        if image.is_float and encoding == "auto":
            encoding = "unsigned" if is_unsigned_pair(pair_of_channels(image, order)) else "signed"
        image = as_three_channels(image, components, order, encoding)
    xyz = finite(image, color_channels(image))
    if order != (0, 1, 2):
        xyz = xyz[..., list(order)]
    if image.is_float:
        unsigned = encoding == "unsigned" or (encoding == "auto" and is_unsigned_float(xyz))
        coding = codec.Coding(image.max_code, signed=not unsigned, is_float=True)
        return Channels(image, xyz, swizzle, asked, coding, components, components_from, "assumed")
    zero_code, zero_code_from = _find_zero_code(image, xyz, options)
    coding = codec.Coding(image.max_code, zero_code)
    return Channels(image, xyz, swizzle, asked, coding, components, components_from, zero_code_from)


def _order(swizzle: codec.Swizzle) -> tuple[int, ...]:
    return tuple(channel for channel, _ in swizzle)


def _find_zero_code(image: RasterImage, xyz: NDArray[Any], options: ReadOptions) -> tuple[str, str]:
    """The zero code of integers, and its source."""
    if options.zero_code != "auto":
        return options.zero_code, "given"
    stated = image.attributes.get("zero_code")
    if stated in ZERO_CODES:
        return stated, "file"
    found = detect_zero_code(xyz)
    return ("127.5", "assumed") if found is None else (found, "found")


def color_channels(image: RasterImage) -> NDArray[Any]:
    """The three colour channels as stored.

    Raises
    ------
    InputError
        If the picture has fewer than three.
    """
    if not {"R", "G", "B"} <= set(image.channels):
        two = "; if the two are x and y, use `components='xy'`" if len(image.channels) == 2 else ""
        raise InputError(
            f"{image.name}: has {counted(len(image.channels), 'channel')} ({', '.join(image.channels)}); "
            f"a normal map needs red, green and blue; a grey picture is a height or depth image{two}"
        )
    if image.channels[:3] == ("R", "G", "B"):
        return image.pixels[..., :3]
    return image.pixels[..., [image.channels.index(c) for c in "RGB"]]


def finite(image: RasterImage, rgb: NDArray[Any], first: tuple[int, int] = (0, 0)) -> NDArray[Any]:
    """Replace NaN and infinity by 0 where alpha is 0; refuse them anywhere else.

    Parameters
    ----------
    image : RasterImage
    rgb : (H, W, 3)
    first : (int, int)
        Row and column of the first pixel in the whole picture, for the message.

    Raises
    ------
    InputError
    """
    if not image.is_float:
        return rgb
    alpha = image.alpha
    if alpha is not None and not np.isfinite(alpha).all():
        raise InputError(
            f"{image.name}: alpha holds NaN or infinite values; write the file again with alpha from 0 to 1"
        )
    if all(np.isfinite(rgb[row : row + _ROWS_AT_ONCE]).all() for row in range(0, len(rgb), _ROWS_AT_ONCE)):
        return rgb
    bad = ~np.isfinite(rgb).all(axis=-1)
    if alpha is not None:
        bad &= alpha > 0
    if bad.any():
        row, col = np.argwhere(bad)[0]
        raise InputError(
            f"{image.name}: found {counted(int(bad.sum()), 'pixel')} with NaN or infinite values, the first at "
            f"x={col + first[1]}, y={row + first[0]}; repair them or make them transparent (alpha 0)"
        )
    replaced: NDArray[Any] = np.nan_to_num(rgb, nan=0.0, posinf=0.0, neginf=0.0)
    return replaced


def is_unsigned_float(rgb: NDArray[Any]) -> bool:
    """Whether floats hold (n + 1)/2: none is negative and 2v - 1 is closer to unit length than v."""
    if float(rgb.min()) < -1e-3:
        return False
    # white, grey and black backgrounds prove nothing
    telling = rgb[np.ptp(rgb, axis=-1) > 1e-3]
    if not telling.size:
        return False
    sample = telling[:: max(1, len(telling) // 100_000)].astype(np.float64)
    as_signed = np.abs(np.linalg.norm(sample, axis=1) - 1)
    as_unsigned = np.abs(np.linalg.norm(codec.decode_shares(sample), axis=1) - 1)
    return bool(np.median(as_unsigned) < np.median(as_signed))


def as_read(image: RasterImage, channels: Channels) -> RasterImage:
    """The picture as stored in its file, with the missing blue of a two-component map added."""
    image, _ = arranged(image, channels.asked, channels.components)
    if channels.components == "xyz":
        return image
    return as_three_channels(image, channels.components, channels.order, channels.encoding)

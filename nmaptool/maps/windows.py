"""Decode a window of a large normal map, as a part of the whole."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.core.vectors import make_flat, unit
from nmaptool.maps import codec
from nmaptool.maps.background import Background, Span, color_slack, hex_codes, impossible_colors, near_color
from nmaptool.maps.channels import Channels, color_channels, finite
from nmaptool.maps.coverage import cover
from nmaptool.maps.decoding import Decoded
from nmaptool.maps.fringe import RIM_MARGIN_PX
from nmaptool.maps.layouts import arranged, straightened
from nmaptool.maps.patches import SPECK_MARGIN_PX, large_patches
from nmaptool.maps.settled import SettledReading, narrowed_as_settled
from nmaptool.maps.two_channel import as_three_channels, completed
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage

# no pixel depends on one farther away: a window with this margin is decoded as the whole
WINDOW_MARGIN_PX = RIM_MARGIN_PX + SPECK_MARGIN_PX


def decode_window(
    image: RasterImage, settled: SettledReading, decoding: Decoding, first: tuple[int, int] = (0, 0)
) -> NormalMap:
    """Decode a window of a large map into unit normals in eye space.

    It differs from `nmaptool.decode_normal_map` with the same options in two rules, which depend on few pixels around
    each: a patch of a background colour counts if it has at least 16 px, whatever the size of the map; and rims are
    repaired as `nmaptool.maps.fringe.repair_rim` does in windows.

    Parameters
    ----------
    image : RasterImage
        The window, with a margin of ``WINDOW_MARGIN_PX`` where the map goes on.
    settled : SettledReading
    decoding : Decoding
        The record of the decisions, which the result takes over.
    first : (int, int)
        Row and column of the window's first pixel in the map, for messages.

    Returns
    -------
    NormalMap
        Of the window with its margin.

    Raises
    ------
    InputError
        If it holds NaN or infinity where it is defined, or finer values than the rest of the map.
    """
    return decode_window_as_stored(image, settled, decoding, first)[0].normal_map


def decode_window_as_stored(
    image: RasterImage, settled: SettledReading, decoding: Decoding, first: tuple[int, int] = (0, 0)
) -> tuple[Decoded, Mask]:
    """Decode a window as `decode_window`, and keep the vectors as stored.

    Returns
    -------
    decoded : Decoded
        As by `nmaptool.decode_image`.
    repaired : (H, W) bool
        The pixels of rims, which got other vectors.
    """
    channels = _channels(image, settled, first)
    vectors = codec.decode_map(channels.xyz, channels.coding)
    mixed = vectors
    if channels.components != "xyz":
        mixed = vectors[..., :2]
        vectors = completed(mixed, channels.components)
    background = _background(channels, settled, mixed.shape[2])
    covered = cover(vectors, mixed, channels, background, in_window=True)
    normals = unit(covered.vectors)
    signs = codec.signs_of(channels.asked, settled.green)
    if -1 in signs:
        codec.apply_signs(normals, signs, out=normals)
        vectors = codec.apply_signs(vectors, signs)
    make_flat(normals, covered.coverage <= 0)
    foreground = (covered.coverage >= 0.5) & ~covered.background
    normal_map = NormalMap(normals, covered.coverage, image.frame, foreground, image.name, decoding)
    return Decoded(vectors, background, normal_map, channels), covered.rim


def _channels(image: RasterImage, settled: SettledReading, first: tuple[int, int]) -> Channels:
    """The stored values of x, y and z, found as `nmaptool.maps.channels.find_channels` does, but without a search."""
    asked = codec.parse_swizzle(settled.swizzle or "r,g,b")
    image, swizzle = arranged(straightened(image, settled.curve), asked, settled.components)
    order = tuple(channel for channel, _ in swizzle)
    image = narrowed_as_settled(image, settled)
    if settled.components != "xyz":
        image = as_three_channels(image, settled.components, order, settled.encoding, settled.keeps_grey)
    xyz: NDArray[Any] = finite(image, color_channels(image), first)
    if order != (0, 1, 2):
        xyz = xyz[..., list(order)]
    signed = image.is_float and settled.encoding == "signed"
    coding = codec.Coding(image.max_code, settled.zero_code, signed, image.is_float)
    return Channels(image, xyz, swizzle, asked, coding, settled.components, "given", "given")


def _background(channels: Channels, settled: SettledReading, components: int) -> Background:
    """The background of the settled kind."""
    image, xyz, wanted = channels.image, channels.xyz, settled.background_color
    nothing: NDArray[np.bool_] = np.zeros(xyz.shape[:2], bool)
    if wanted == "none":
        return Background("none", nothing)
    if wanted == "alpha":
        return Background("alpha", nothing if image.alpha is None else image.alpha < 0.5)
    span = Span(settled.lowest, float(image.max_code))
    slack = color_slack(image, span)
    if wanted.startswith("#"):
        codes = hex_codes(wanted, span, channels.order)[:components]
        return Background(wanted, near_color(xyz, codes, slack), codes)
    known = impossible_colors(span).get(wanted)
    if known is None:  # grey in signed floats is not a colour
        return Background("none", nothing)
    return Background(wanted, large_patches(near_color(xyz, known, slack)), known)

"""Layouts of channels that need more than an order: presets, x in alpha, and codes that went through a curve."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import UsageError
from nmaptool.maps import codec
from nmaptool.maps.background import alpha_is_data
from nmaptool.options import ReadOptions
from nmaptool.types.picture import RasterImage

_SAMPLE = 20_000
# codes that differ by no more than this, in 8-bit steps, are constant
_CONSTANT = 2
# a pair is x and y if at most this share of it is longer than 1
_MOST_TOO_LONG, _LONGEST = 0.01, 1.02
# alpha is a component if at least this share of it is neither 0 nor 1
_LEAST_PARTIAL = 0.3
# a curve explains the lengths if this share of vectors at most is then off, and this many times fewer than before
_STILL_OFF, _TIMES_FEWER = 0.1, 5
LENGTH_OFF = 0.1
# alpha between these is partial; this many such pixels show whether colours were multiplied: then at least this share
# of their colours is no larger than alpha
_LEAST_ALPHA, _MOST_ALPHA, _PARTIAL_PIXELS, _BELOW_ALPHA = 0.1, 0.9, 50, 0.98


class Layout(NamedTuple):
    """The options with which a picture is read, after presets, and the preset with its source.

    Attributes
    ----------
    options : ReadOptions
    preset : str or None
        Name of the preset.
    source : str
        ``given`` or ``found``; ``assumed`` if there is no preset.
    """

    options: ReadOptions
    preset: str | None
    source: str


def settle_layout(image: RasterImage, options: ReadOptions) -> Layout:
    """Apply the preset that was given, or that of an unmistakable layout."""
    if options.from_ != "auto":
        return Layout(options.as_written_by(options.from_), options.from_, "given")
    uses_alpha = options.swizzle is None or "a" in options.swizzle.lower()
    if uses_alpha and options.components == "auto" and _is_dxt5nm(image):
        return Layout(options.as_written_by("dxt5nm"), "dxt5nm", "found")
    return Layout(options, None, "assumed")


def _is_dxt5nm(image: RasterImage) -> bool:
    """Whether x is in alpha and y in green: red holds nothing, and alpha and green make a vector."""
    if image.channels != ("R", "G", "B", "A") or image.is_float or image.attributes.get("kind") == "normal":
        return False
    codes = image.pixels.reshape(-1, 4)
    codes = codes[:: max(1, len(codes) // _SAMPLE)].astype(np.float64) / image.max_code
    spread = np.ptp(codes, axis=0)
    partial = ((codes[:, 3] > 0.02) & (codes[:, 3] < 0.98)).mean()
    if spread[0] > _CONSTANT / 255 or spread[1] <= _CONSTANT / 255 or partial < _LEAST_PARTIAL:
        return False
    return bool((np.linalg.norm(codec.decode_shares(codes[:, [3, 1]]), axis=1) > _LONGEST).mean() <= _MOST_TOO_LONG)


def arranged(
    image: RasterImage, swizzle: codec.Swizzle, components: str, asked_by: str = "the order of its channels"
) -> tuple[RasterImage, codec.Swizzle]:
    """Move alpha to the colour channel that the swizzle leaves out, if it uses alpha; the result has no alpha.

    With components "xy", the channel of z becomes 0: it holds nothing. ``asked_by`` names the option for errors.

    Raises
    ------
    UsageError
        If the picture has no alpha.
    """
    used = [channel for channel, _ in swizzle]
    if codec.ALPHA not in used:
        return image, swizzle
    if image.channels != ("R", "G", "B", "A"):
        raise UsageError(
            f"{image.name}: {asked_by} uses alpha, but its channels are {', '.join(image.channels)}; "
            "take x, y and z from these"
        )
    (free,) = {0, 1, 2} - set(used)
    places = [0, 1, 2]
    places[free] = codec.ALPHA
    moved = tuple((free if channel == codec.ALPHA else channel, sign) for channel, sign in swizzle)
    pixels = image.pixels[..., places]
    if components == "xy":
        pixels[..., moved[2][0]] = 0
    return replace(image, pixels=pixels, channels=("R", "G", "B")), moved


def straightened(image: RasterImage, curve: str) -> RasterImage:
    """Undo a curve in the colour channels; codes become floats from 0 to 1.

    Parameters
    ----------
    image : RasterImage
    curve : str
        As in `ReadOptions`.
    """
    if curve == "none":
        return image
    shares = image.pixels.astype(np.float32) / np.float32(image.max_code)
    colors = [i for i, name in enumerate(image.channels) if name != "A"]
    with np.errstate(over="ignore"):  # infinity is refused later, if it matters
        straight = _undone(shares[..., colors], curve)
    if not image.is_float:  # the code that 0 was rounded to is 0, so flat areas stay flat
        middle = np.floor(_applied(0.5, curve) * image.max_code + 0.5)
        straight[image.pixels[..., colors] == middle] = 0.5
    shares[..., colors] = straight
    return replace(image, pixels=shares, bits=32)


def _undone(shares: NDArray[Any], curve: str) -> NDArray[Any]:
    """Shares of the largest code before a curve was applied (IEC 61966-2-1 for sRGB)."""
    if curve == "video":
        return (shares * 255 - 16) / 219
    if curve == "srgb":  # the values were encoded, so decode them
        return np.where(shares <= 0.04045, shares / 12.92, ((shares.clip(0) + 0.055) / 1.055) ** 2.4)
    return np.where(shares <= 0.0031308, shares * 12.92, 1.055 * shares.clip(0) ** (1 / 2.4) - 0.055)


def _applied(share: float, curve: str) -> float:
    """The share of the largest code that a curve makes of one above its linear part: the inverse of `_undone`."""
    if curve == "video":
        return (16 + 219 * share) / 255
    if curve == "srgb":
        return float(1.055 * share ** (1 / 2.4) - 0.055)
    return float(((share + 0.055) / 1.055) ** 2.4)


def find_curve(image: RasterImage, background: Mask) -> str | None:
    """The curve that the codes went through, if undoing it gives unit vectors and reading them as stored does not.

    Parameters
    ----------
    image : RasterImage
        With red, green and blue.
    background : (H, W) bool
        Pixels to leave out.
    """
    at = np.flatnonzero(~background)
    colors = [image.channels.index(name) for name in "RGB"]
    flat = image.pixels.reshape(-1, len(image.channels))
    shares = flat[at[:: max(1, len(at) // _SAMPLE)]][:, colors].astype(np.float64) / image.max_code
    if not len(shares) or not (shares.min() >= 0 and shares.max() <= 1):
        return None

    def off(values: NDArray[Any]) -> float:
        lengths = np.linalg.norm(codec.decode_shares(values), axis=1)
        return float((np.abs(lengths - 1) > LENGTH_OFF).mean())

    curves = {curve: off(_undone(shares, curve)) for curve in ("srgb", "linear", "video")}
    best = min(curves, key=lambda curve: curves[curve])
    return best if curves[best] <= min(_STILL_OFF, off(shares) / _TIMES_FEWER) else None


def is_premultiplied(image: RasterImage) -> bool:
    """Whether colours were multiplied by alpha, so that dividing by alpha restores unit vectors."""
    if image.channels != ("R", "G", "B", "A") or alpha_is_data(image):
        return False
    alpha = image.pixels[..., codec.ALPHA]
    partial = (alpha > _LEAST_ALPHA * image.max_code) & (alpha < _MOST_ALPHA * image.max_code)
    if np.count_nonzero(partial) < _PARTIAL_PIXELS:
        return False
    shares = image.pixels[partial].astype(np.float64) / image.max_code
    colors, alphas = shares[:, :3], shares[:, 3:]
    if np.mean(colors <= alphas + 2 / 255) < _BELOW_ALPHA:
        return False
    straight = np.abs(np.linalg.norm(codec.decode_shares(colors), axis=1) - 1)
    divided = np.abs(np.linalg.norm(codec.decode_shares(colors / alphas), axis=1) - 1)
    return bool(np.median(divided) < 0.5 * np.median(straight))

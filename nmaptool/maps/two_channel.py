"""Maps with two values per pixel, x and y or octahedral codes, and the vectors computed from them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import counted

# (x, y) longer than this is not a normal but a white or black background
_LONGEST_XY = 1.1
# octahedral codes with both values beyond this face straight away from the viewer: white or black backgrounds again
_CORNER = 0.9
# a pixel is grey, not flat, if all three values are within this many 8-bit steps of the middle
_GREY_STEPS = 8.0
# blue is not z if more than this share of the vectors is not of unit length
_BLUE_OFF_SHARE = 0.02
_SAMPLE = 4096


def derive_z(xy: NDArray[Any]) -> Float32:
    """Compute vectors from x and y: z = sqrt(max(0, 1 - x^2 - y^2)), towards the viewer.

    Parameters
    ----------
    xy : (..., 2) float

    Returns
    -------
    (..., 3) float32
        Unit vectors; where (x, y) is longer than 1, z is 0 and the vector keeps that length.

    Examples
    --------
    >>> derive_z(np.array([0.6, 0.0])).tolist()
    [0.6000000238418579, 0.0, 0.800000011920929]
    """
    x, y = xy[..., 0].astype(np.float64), xy[..., 1].astype(np.float64)
    return np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], axis=-1).astype(np.float32)


def unfold_octahedral(codes: NDArray[Any]) -> Float32:
    """Decode octahedral codes: fold the square [-1, 1]^2 into an octahedron and project that onto the sphere.

    The middle of the square is +z, the diamond |u| + |v| = 1 is z = 0, the corners are -z (Meyer et al. 2010; ``oct``
    of Cigolle et al. 2014).

    Parameters
    ----------
    codes : (..., 2) float
        In [-1, 1]; others are clipped to the edge of the square.

    Returns
    -------
    (..., 3) float32
        Unit vectors; a code outside the square gives a vector whose length is the larger absolute value of the code.

    Examples
    --------
    >>> unfold_octahedral(np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 1.0]])).round(6).tolist()
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
    """
    codes = codes.astype(np.float64)
    far = np.maximum(1.0, np.abs(codes).max(axis=-1, keepdims=True))
    u, v = np.moveaxis(codes.clip(-1, 1), -1, 0)
    z = 1 - np.abs(u) - np.abs(v)
    behind = np.maximum(-z, 0)
    # + 0: the corners give 0, not -0
    vectors = np.stack([u - np.copysign(behind, u) + 0.0, v - np.copysign(behind, v) + 0.0, z], axis=-1)
    vectors *= far / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors.astype(np.float32)


def completed(codes: NDArray[Any], components: str) -> Float32:
    """Convert two codes in [-1, 1] to (..., 3) float32 vectors, with `derive_z` ("xy") or `unfold_octahedral`."""
    return unfold_octahedral(codes) if components == "octahedral" else derive_z(codes)


def find_components(image: RasterImage, wanted: str, order: tuple[int, ...]) -> tuple[str, str]:
    """The components that a picture holds, "xyz", "xy" or "octahedral", and the source of this.

    Parameters
    ----------
    image : RasterImage
    wanted : str
        "auto", or the components that were given.
    order : tuple of int
        Which of the channels R, G, B feeds x, y and z.

    Returns
    -------
    components, components_from : str
    """
    if wanted != "auto":
        return wanted, "given"
    if {"R", "G"} <= set(image.channels) and "B" not in image.channels:
        return "xy", "found"
    if image.attributes.get("kind") == "normal":  # nmaptool's own files hold all three
        return "xyz", "file"
    if {"R", "G", "B"} <= set(image.channels) and _blue_is_not_z(image, order):
        return "xy", "found"
    return "xyz", "assumed"


def _blue_is_not_z(image: RasterImage, order: tuple[int, ...]) -> bool:
    """Whether blue is constant and cannot be z, while red and green vary."""
    at = [image.channels.index("RGB"[channel]) for channel in order]
    flat = image.pixels.reshape(-1, len(image.channels))
    for step in (max(1, len(flat) // _SAMPLE), 1):  # a few pixels decide for most maps
        codes = flat[::step]
        if "A" in image.channels:
            codes = codes[codes[:, image.channels.index("A")] > 0]
        blue = codes[:, at[2]]
        if blue.size and blue.min() != blue.max():  # also for NaN
            return False
    codes = codes[:, at]
    if not codes.size or not np.isfinite(codes).all() or min(np.ptp(codes[:, 0]), np.ptp(codes[:, 1])) == 0:
        return False
    if image.is_float:
        vectors = codes * 2 - 1 if is_unsigned_pair(codes[:, :2]) else codes
        tolerance = 4e-3
    else:
        vectors = codes * (2 / image.max_code) - 1
        tolerance = 7 / image.max_code  # rounding or truncation of three codes
    if vectors[0, 2] <= 0:  # the whole picture would face away
        return True
    off = np.abs(np.einsum("ij,ij->i", vectors, vectors, dtype=np.float64) - 1) > tolerance
    return bool(off.mean() > _BLUE_OFF_SHARE)


def is_unsigned_pair(codes: NDArray[Any]) -> bool:
    """Whether two floats per pixel hold (n + 1)/2.

    True if none is negative, and 2v - 1 is too long for x and y less often than v, or as often but closer to flat.
    """
    pairs = codes.reshape(-1, 2)
    pairs = pairs[np.isfinite(pairs).all(axis=1)].astype(np.float64)
    if not len(pairs) or pairs.min() < -1e-3:
        return False
    telling = pairs[np.ptp(pairs, axis=1) > 1e-3]  # white, grey and black backgrounds prove nothing
    telling = telling if len(telling) else pairs
    sample = telling[:: max(1, len(telling) // 100_000)]
    signed, unsigned = np.linalg.norm(sample, axis=1), np.linalg.norm(2 * sample - 1, axis=1)
    too_long = float((unsigned > 1.01).mean()), float((signed > 1.01).mean())
    if too_long[0] != too_long[1]:
        return too_long[0] < too_long[1]
    return bool(np.median(unsigned) < np.median(signed))


def pair_of_channels(image: RasterImage, order: tuple[int, ...]) -> NDArray[Any]:
    """(H, W, 2): the two channels that feed x and y, as stored.

    For a picture with red, green and blue, those given by ``order``; for one with two channels, both, even grey and
    alpha.

    Raises
    ------
    InputError
        If it has only one channel, or too many to choose from.
    UsageError
        If ``order`` uses a blue that is missing.
    """
    names = image.channels
    if {"R", "G", "B"} <= set(names):
        return image.pixels[..., [names.index("RGB"[channel]) for channel in order[:2]]]
    both = [i for i, name in enumerate(names) if name != "A"]
    if len(both) == 1 and len(names) == 2:  # grey and alpha
        both = [0, 1]
    if len(both) != 2:
        raise InputError(
            f"{image.name}: has {counted(len(names), 'channel')} ({', '.join(names)}); a two-component map needs "
            "two channels, or the red and green of three"
        )
    if 2 in order[:2]:
        raise UsageError(f"{image.name}: has no blue; take x and y from r and g, such as `swizzle='-g,r,b'`")
    return image.pixels[..., [both[channel] for channel in order[:2]]]


def as_three_channels(
    image: RasterImage, components: str, order: tuple[int, ...], encoding: str, keep_grey: bool | None = None
) -> RasterImage:
    """Return the picture with the blue channel of a three-component map, so that it can be read like one.

    Where the two codes are not those of a normal, blue is their mean, so that a white background stays white and a
    black one black. A grey background stays grey if the picture's own blue varies and is grey there too.

    Parameters
    ----------
    image : RasterImage
    components : str
        "xy" or "octahedral".
    order : tuple of int
        Which of the channels R, G, B feeds x, y and z.
    encoding : str
        "signed" or "unsigned", for floats.
    keep_grey : bool, optional
        Whether grey stays grey. Default: as the picture's own blue says.

    Returns
    -------
    RasterImage
        Channels R, G, B, and A unless alpha is one of the two.
    """
    pair = pair_of_channels(image, order)
    signed = image.is_float and encoding == "signed"
    codes = pair.astype(np.float64) / image.max_code
    codes = codes if signed else codes * 2 - 1
    with np.errstate(invalid="ignore", over="ignore"):  # NaN is refused later, if it matters
        blue = completed(codes, components)[..., 2].astype(np.float64)
        if components == "octahedral":
            nothing = (codes > _CORNER).all(axis=-1) | (codes < -_CORNER).all(axis=-1)
        else:
            nothing = np.hypot(codes[..., 0], codes[..., 1]) > _LONGEST_XY
        blue = np.where(nothing, codes.mean(axis=-1), blue)
    stored = blue if signed else (blue + 1) / 2
    if not image.is_float:
        stored = np.floor(stored * image.max_code + 0.5).clip(0, image.max_code)
    three = np.empty((*pair.shape[:2], 3), image.pixels.dtype)
    three[..., list(order[:2])] = pair
    three[..., order[2]] = stored
    if blue_varies(image, order) if keep_grey is None else keep_grey:
        _keep_grey(image, order, three, signed)
    if "A" not in image.channels or len(image.channels) == 2:
        return replace(image, pixels=three, channels=("R", "G", "B"))
    alpha = image.pixels[..., [image.channels.index("A")]]
    return replace(image, pixels=np.concatenate([three, alpha], axis=2), channels=("R", "G", "B", "A"))


def blue_varies(image: RasterImage, order: tuple[int, ...]) -> bool:
    """Whether a picture has a blue, or the channel in its place, that is not the same everywhere."""
    if not {"R", "G", "B"} <= set(image.channels):
        return False
    blue = image.pixels[..., image.channels.index("RGB"[order[2]])]
    return bool(blue.min() != blue.max())


def _keep_grey(image: RasterImage, order: tuple[int, ...], three: NDArray[Any], signed: bool) -> None:
    """Restore the stored blue where the picture is grey."""
    blue = image.pixels[..., image.channels.index("RGB"[order[2]])]
    middle = 0.0 if signed else image.max_code / 2
    slack = _GREY_STEPS * image.max_code / 255
    grey = np.abs(blue.astype(np.float64) - middle) <= slack
    for channel in order[:2]:
        grey &= np.abs(three[..., channel].astype(np.float64) - middle) <= slack
    three[..., order[2]][grey] = blue[grey]

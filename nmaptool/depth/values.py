"""The grey values of a raw picture, where they are known, the size of their steps and their noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.maps import codec
from nmaptool.types.picture import RasterImage

# largest difference between the channels of a grey picture in 8-bit codes: on average, and for all but _GREY_FEW of the
# pixels
_GREY_MEAN, _GREY_MOST, _GREY_FEW = 4.0, 16.0, 1e-3
# values are steps if the median value occurs in this many pixels of a sample
_PIXELS_A_LEVEL = 8
_SAMPLE = 1 << 17
# fewer values than this are terraces, not the steps of a slope
_LEAST_STEPS = 8
# floats are steps if there are this many levels, spaced this evenly, with at least this share of them used
_LEAST_LEVELS, _UNEVEN, _FILLED = 48, 0.05, 0.5
# what renderers store where there is nothing: the largest half float, and Blender's value
BLENDER_NOTHING = 1e10
NOTHING = (65504.0, BLENDER_NOTHING)
# larger floats mean "empty", such as the 3.4e38 of elevation models; less than 1 over it counts as 0
INFINITE = 1e30
# a picture in false colours has at most this many of them; a photograph has far more
_FALSE_COLORS = 300
_BLOCK = 16
# the noise of a picture is this percentile of the noise in its blocks that are not flat
_QUIET = 20
# noise below this share of a step is due to the step
_STEP_NOISE = 0.45
_HIGH_PASS = 6.0
# trimming ignores edges in a block: the mean of the smaller 60% of |x|, as a share of the deviation of a normal x
_TRIMMED, _TRIMMED_MEAN = 0.6, 0.3966
# a block is flat unless this share of its pixels differs from the values that their neighbours predict
_LIVELY = 0.25


@dataclass(frozen=True, eq=False)
class GreyValues:
    """The values that a picture stores.

    Attributes
    ----------
    values : (H, W) float32
        Codes, or the floats of a floating-point file; 0 where unknown.
    known : (H, W) bool
        Where there is a value.
    top : float
        Largest integer code; 1 for floating point.
    is_float : bool
    bits : int
        Bits in use: 8 for a 16-bit file with 8-bit steps.
    noisy_grey : bool
        Whether colour channels were averaged.
    nothing : int
        Number of pixels without a depth: transparent, NaN, infinite, or a value that means "empty".
    empty : mapping of str to int
        The values that mean "empty", and the number of pixels of each.
    dropouts : (H, W) bool or None
        Pixels without a depth inside which there may be surface, such as those of a depth camera without a reading.
    """

    values: Float32
    known: Mask
    top: float
    is_float: bool
    bits: int
    noisy_grey: bool
    nothing: int
    empty: Mapping[str, int] = field(default_factory=dict)
    dropouts: Mask | None = None


def grey_values(image: RasterImage, empty: tuple[float, ...] = (), *, part: bool = False) -> GreyValues:
    """Return the grey values of a depth or height picture.

    Parameters
    ----------
    image : RasterImage
    empty : tuple of float
        Stored values that mean "no depth", besides NaN and infinity.
    part : bool
        Whether it is a part of a larger picture: then it is not narrowed to 8-bit codes, and may be empty.

    Raises
    ------
    InputError
        If it is coloured, has unknown channels, or no value at all.
    """
    stored = image.pixels[..., 0]  # before 16 bits are narrowed to 8
    if not part and (not image.is_float or _may_be_codes(image.pixels)):
        image = codec.narrowed(image)
    values, averaged = _one_channel(image)
    known = np.ones(values.shape, bool)
    counts: dict[str, int] = {}
    dropouts = None
    if image.is_float:
        np.isfinite(values, out=known)
        known &= np.abs(values) < INFINITE
        if not known.all():
            dropouts = np.isnan(values)
            _count(counts, "NaN", int(np.count_nonzero(dropouts)))
            _count(counts, "infinite", int(np.count_nonzero(~known)) - counts.get("NaN", 0))
    for value in empty:
        found = stored == stored.dtype.type(value) if _fits(value, stored.dtype) else np.zeros_like(known)
        found &= known
        if _count(counts, f"{value:g}", int(np.count_nonzero(found))):
            known &= ~found
            if value not in NOTHING:
                dropouts = found if dropouts is None else dropouts | found
    if image.alpha is not None:
        opaque = image.alpha > 0
        known &= opaque
        dropouts = None if dropouts is None else dropouts & opaque
    unknown = ~known
    nothing = int(np.count_nonzero(unknown))
    if nothing == known.size and not part:
        what = (
            ", ".join(("transparent", *counts)) if set(counts) - {"NaN", "infinite"} else "transparent, NaN or infinite"
        )
        raise InputError(f"{image.name}: no pixel has a depth: all are {what}")
    if nothing:
        values[unknown] = 0
    bits = 8 if image.pixels.dtype == np.uint8 else image.bits
    top = float(image.max_code)
    return GreyValues(values, known, top, image.is_float, bits, averaged, nothing, counts, dropouts)


def extremes(values: Float32, known: Mask) -> tuple[float, float]:
    """Return the lowest and the highest known value."""
    if known.all():  # several times faster
        return float(values.min()), float(values.max())
    return float(values.min(where=known, initial=np.inf)), float(values.max(where=known, initial=-np.inf))


def _count(counts: dict[str, int], name: str, number: int) -> int:
    """Add a number of pixels, if there are any, and return it."""
    if number:
        counts[name] = counts.get(name, 0) + number
    return number


def _fits(value: float, kind: np.dtype[Any]) -> bool:
    """Whether a picture of this type can store the value."""
    if kind.kind == "f":
        return abs(value) < INFINITE  # others count as infinite
    return value == int(value) and 0 <= value <= np.iinfo(kind).max


def _may_be_codes(pixels: NDArray[Any]) -> bool:
    """Whether a sample of the floats is near multiples of 1/255; checking all of them is slow."""
    sample = pixels.ravel()[:: max(1, pixels.size // _SAMPLE)]
    if not (np.abs(sample) <= 1).all():  # also for NaN
        return False
    codes = sample * np.float32(255)
    return bool(np.all(np.abs(codes - np.rint(codes)) < 0.1))


def _one_channel(image: RasterImage) -> tuple[Float32, bool]:
    """Return (H, W) float32 and whether colours had to be averaged."""
    names = [i for i, name in enumerate(image.channels) if name != "A"]
    if len(names) == 1 or not names:
        return image.pixels[..., names[0] if names else 0].astype(np.float32), False
    if [image.channels[i] for i in names] != ["R", "G", "B"]:
        raise InputError(
            f"{image.name}: has the channels {', '.join(image.channels)}, but a depth picture has one grey channel; "
            "name its layer, such as FILE.exr:depth"
        )
    red, green, blue = (image.pixels[..., i] for i in names)
    if _same(red[::7], green[::7]) and _same(red, green) and _same(red, blue):
        return red.astype(np.float32), False
    first = red.astype(np.float32)
    total = first.copy()
    code = image.max_code / 255
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and infinite values
        for other in (green, blue):
            apart = np.abs(other - first)
            apart[np.isnan(apart)] = 0
            few = np.count_nonzero(apart > _GREY_MOST * code) > _GREY_FEW * apart.size
            if few or float(apart.mean()) > _GREY_MEAN * code:
                raise InputError(
                    f"{image.name}: is a colour picture, but depth and height pictures are grey; {_remedy(image)}"
                )
            total += other
    total /= np.float32(3)
    return total, True


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _remedy(image: RasterImage) -> str:
    """What to do about a picture in colours, which may be a depth picture in false ones."""
    rows, cols = (max(1, side // 256) for side in image.pixels.shape[:2])
    sample = image.pixels[::rows, ::cols, :3].reshape(-1, 3)
    again = (
        "export the depth picture again in grey and alone (with Depth Anything, its options grayscale and pred-only)"
    )
    if len(np.unique(sample, axis=0)) <= _FALSE_COLORS < len(sample):
        return f"false colours cannot be turned back into exact depths; {again}"
    return f"{again}; a normal map needs no conversion"


def step_of(grey: GreyValues) -> float:
    """Return the size of the steps between the values of a picture, in their unit; 0 if no steps are found."""
    sample = grey.values[grey.known]
    sample = sample[:: max(1, sample.size // _SAMPLE)]
    levels, counts = np.unique(sample, return_counts=True)
    if len(levels) < _LEAST_STEPS:
        return 0.0 if grey.is_float else 1.0
    if np.median(counts) < _PIXELS_A_LEVEL:
        return 0.0 if grey.is_float else 1.0
    # the median gap, weighted by the rarer of its two values: a value far from the others counts little, however common
    gaps = np.diff(levels.astype(np.float64))
    weight = np.minimum(counts[:-1], counts[1:])
    order = np.argsort(gaps)
    middle = int(np.searchsorted(np.cumsum(weight[order]), weight.sum() / 2))
    step = float(gaps[order][min(middle, len(gaps) - 1)])
    return step if not grey.is_float or _even(gaps / step) else 0.0


def _even(gaps: NDArray[np.float64]) -> bool:
    """Whether floats are evenly spaced, like integers: enough levels, and few left out."""
    whole = np.rint(gaps)
    near = np.abs(gaps - whole) < _UNEVEN
    return len(gaps) >= _LEAST_LEVELS and bool(near.all()) and len(gaps) >= _FILLED * whole.sum()


def noise_of(values: Float32, known: Mask, step: float) -> float:
    """Return the standard deviation of the noise in the quietest parts that are not flat; 0 if it is due to the steps.

    Parameters
    ----------
    values : (H, W) float32
    known : (H, W) bool
    step : float
        Size of the steps between values; they do not count as noise.
    """
    if min(values.shape) < _BLOCK:
        return 0.0
    stride = max(1, int(np.sqrt(values.size / 4e6)))
    strips = []
    for top in range(0, values.shape[0] - _BLOCK + 1, _BLOCK * stride):
        strip = slice(top, top + _BLOCK)
        strips.append(_block_noise(values[strip], known[strip]))
    found = np.concatenate(strips)
    found = found[found > 0]
    if not found.size:
        return 0.0
    noise = float(np.percentile(found, _QUIET))
    return noise if noise > _STEP_NOISE * step else 0.0


def _block_noise(strip: Float32, known: Mask) -> NDArray[Any]:
    """Return the noise of each block of a strip (Immerkaer's method); 0 where not all pixels are known."""
    whole = strip.shape[1] // _BLOCK * _BLOCK
    across = strip[:, :-2] - 2 * strip[:, 1:-1] + strip[:, 2:]
    high = np.abs(across[:-2] - 2 * across[1:-1] + across[2:])
    padded = np.zeros(strip.shape, np.float32)
    padded[1:-1, 1:-1] = high
    blocks = padded[1:-1, :whole].reshape(_BLOCK - 2, -1, _BLOCK)
    inside = blocks[:, :, 1:-1]
    ordered = np.sort(inside.transpose(1, 0, 2).reshape(inside.shape[1], -1), axis=1)
    mean = ordered[:, : int(_TRIMMED * ordered.shape[1])].mean(axis=1) / (_TRIMMED_MEAN * _HIGH_PASS)
    sound = known[:, :whole].reshape(_BLOCK, -1, _BLOCK).all(axis=(0, 2))
    sound &= (inside != 0).mean(axis=(0, 2)) > _LIVELY
    return np.asarray(np.where(sound, mean, 0))

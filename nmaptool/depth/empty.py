"""Find stored values that mean "no depth", such as 1e10, -9999, or the 0 of a depth camera."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.depth.meaning import Meaning, kind_of
from nmaptool.depth.values import INFINITE, NOTHING, GreyValues, extremes
from nmaptool.options import DepthOptions
from nmaptool.types.picture import RasterImage

# what elevation models store where there are no data
_MISSING = (-9999.0, -32768.0, -32767.0, -99999.0)
# a distance this many times that of the near pixels means "empty"; so does the largest one if it is this many times as
# far from the others as these are apart
_FAR, _ALONE = 1e3, 10.0
# the near pixels: this percentile, because nothing or sky often fills more than half of a picture
_NEAR = 5.0
_SAMPLE = 1 << 17
# depth cameras store mm: their largest code is below this share of the codes, and 0 is this far from the least distance
_CAMERA_SHARE, _CAMERA_GAP, _CAMERA_STEPS = 0.25, 64, 16


def depths_of(image: RasterImage, grey: GreyValues, meaning: Meaning, options: DepthOptions) -> GreyValues:
    """Return the heights or distances of a picture without the values that mean "empty"; `empty` may keep those.

    Raises
    ------
    InputError
        If no value remains.
    """
    lowest = extremes(grey.values, grey.known)[0]
    finds = options.empty == "auto"
    is_whole = options.background == "none"
    kind = kind_of(image)
    if finds and grey.is_float and kind != "height":
        grey = _without_marks(grey)
    elif finds and grey.bits == 16 and _may_be_camera(image, meaning, options):
        grey = _without_readings(image, grey, meaning)
    inverse = meaning.values == "disparity" and meaning.absolute
    if inverse or (finds and meaning.absolute and not is_whole):
        least = np.float32(1 / INFINITE if inverse else 0)
        grey = _removed(grey, grey.known & (grey.values <= least), "0 or less" if grey.is_float else "0", dropouts=True)
    if inverse:
        values = np.zeros_like(grey.values)
        np.divide(np.float32(1), grey.values, out=values, where=grey.known)
        grey = replace(grey, values=values, is_float=True)
    if finds and grey.is_float and meaning.absolute and not is_whole and grey.known.any():
        grey = _without_far(grey, plate=kind != "grey" or options.background == "flat")
    if not grey.known.any():
        remedy = (
            "read negative distances as heights, with `values='height'`"
            if lowest < 0
            else "check that this is the depth picture"
        )
        raise InputError(f"{image.name}: no pixel has a depth greater than 0; {remedy}")
    return grey


def _removed(grey: GreyValues, found: Mask, name: str, *, dropouts: bool) -> GreyValues:
    """Return the values without some known pixels."""
    number = int(np.count_nonzero(found))
    if not number:
        return grey
    holes = grey.dropouts
    if dropouts:
        holes = found if holes is None else holes | found
    values = np.where(found, np.float32(0), grey.values)
    counts = {**grey.empty, name: grey.empty.get(name, 0) + number}
    return replace(
        grey, values=values, known=grey.known & ~found, nothing=grey.nothing + number, empty=counts, dropouts=holes
    )


def _without_marks(grey: GreyValues) -> GreyValues:
    """Remove the values of convention that lie further from the others than these are apart."""
    low, high = extremes(grey.values, grey.known)
    for _ in range(len(NOTHING) + len(_MISSING)):
        is_high = high in NOTHING
        mark = high if is_high else low
        if not is_high and low not in _MISSING:
            break
        found = grey.known & (grey.values == np.float32(mark))
        left = extremes(grey.values, grey.known & ~found)
        gap = high - left[1] if is_high else left[0] - low
        if left[0] < left[1] and gap <= left[1] - left[0]:
            break
        grey = _removed(grey, found, f"{mark:g}", dropouts=not is_high)
        low, high = left
        if low > high:  # nothing is left
            break
    return grey


def _without_far(grey: GreyValues, *, plate: bool) -> GreyValues:
    """Remove distances far beyond the others; with ``plate``, keep a flat ground that is merely far behind."""
    values, known = grey.values, grey.known
    limit = _FAR * float(np.percentile(_sample(grey), _NEAR))
    high = extremes(values, known)[1]
    if high > limit:
        found = known & (values > np.float32(limit))
        grey = _removed(grey, found, "far beyond the rest", dropouts=False)
        values, known = grey.values, grey.known
        high = extremes(values, known)[1]
    if plate:
        return grey
    farthest = known & (values == np.float32(high))
    if np.count_nonzero(farthest) > 1:
        low, rest = extremes(values, known & ~farthest)
        if low < rest and high - rest > _ALONE * (rest - low):
            grey = _removed(grey, farthest, f"{high:g}", dropouts=False)
    return grey


def middle_of(grey: GreyValues) -> float:
    """The median of the known values, from a sample."""
    return float(np.median(_sample(grey)))


def _sample(grey: GreyValues) -> Float32:
    stride = max(1, grey.values.size // _SAMPLE)
    return grey.values[grey.known][::stride]


def _may_be_camera(image: RasterImage, meaning: Meaning, options: DepthOptions) -> bool:
    """Whether codes may be the readings of a depth camera: distances, or values of unknown meaning without a plate."""
    if kind_of(image) != "grey":
        return False
    return meaning.is_distance or (meaning.values_from == "assumed" and options.background == "auto")


def _without_readings(image: RasterImage, grey: GreyValues, meaning: Meaning) -> GreyValues:
    """Remove the 0 and the largest code of a depth camera."""
    mask = None if grey.known.all() else grey.known.view(np.uint8)
    pixels = np.ascontiguousarray(image.pixels[..., 0])
    used = np.flatnonzero(cv2.calcHist([pixels], [0], mask, [65536], [0, 65536]))
    if len(used) < 3:
        return grey
    most = _CAMERA_SHARE * grey.top
    rest = used[1:] if used[0] == 0 else used
    saturated = rest[-1] == grey.top and len(rest) > 1 and rest[-2] < most and meaning.is_distance
    rest = rest[:-1] if saturated else rest
    gaps = np.diff(rest)
    usual = float(np.median(gaps)) if len(gaps) else 1.0
    is_camera = rest[-1] < most and rest[0] >= max(_CAMERA_GAP, _CAMERA_STEPS * usual)
    if used[0] == 0 and (is_camera or (meaning.is_distance and meaning.absolute)):  # gaps in a plate of heights stay
        grey = _removed(grey, grey.known & (grey.values == 0), "0", dropouts=meaning.is_distance)
    if saturated:
        grey = _removed(grey, grey.known & (grey.values == np.float32(grey.top)), f"{grey.top:g}", dropouts=False)
    return grey

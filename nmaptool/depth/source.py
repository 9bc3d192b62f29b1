"""The heights of a depth or height picture, and how accurate they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.units import Length
from nmaptool.depth.empty import depths_of
from nmaptool.depth.fill import MOST_PIXELS, fill_holes
from nmaptool.depth.meaning import Meaning, kind_of, meaning_of
from nmaptool.depth.scale import Scale, in_px, settle_scale
from nmaptool.depth.values import GreyValues, extremes, grey_values, noise_of, step_of
from nmaptool.options import DepthOptions
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.plain_arrays import check_sizes

# least noise of a lossy file near edges, in steps
_LOSSY_NOISE = 1.25
# with smaller errors of the slopes, no fit is needed
FINE_SLOPE = 0.012
# slopes of larger heights overflow
_MOST_PX = 1e18
# largest hole that is filled by itself: a share of the longer side, and in px
_HOLE_SHARE, _HOLE_PX = 0.015, 3.0
# smallest jump: in px, in steps of the codes, and in standard deviations of the noise
_JUMP_PX, _JUMP_STEPS, _JUMP_NOISE = 1.0, 4.0, 7.0


@dataclass(frozen=True, eq=False)
class DepthSource:
    """The heights of a picture in px, with their scale, step and noise."""

    image: RasterImage
    grey: GreyValues
    cover: Float32 | None
    meaning: Meaning
    scale: Scale
    heights: Float32
    lowest: float
    step_px: float
    noise_px: float
    in_use: tuple[float, float]
    orientation: int = 1
    fill_px: float = 0.0
    filled: Mask | None = None
    holes: int = 0

    @property
    def least_jump_px(self) -> float:
        """Smallest step that counts as a jump."""
        return max(_JUMP_PX, _JUMP_STEPS * self.step_px, _JUMP_NOISE * self.unsure)

    @property
    def unsure(self) -> float:
        """Least noise of heights near edges, in px; 0 in clean pictures."""
        return max(_LOSSY_NOISE * self.step_px if self.image.lossy else 0.0, self.noise_px)

    def facts(self) -> dict[str, Any]:
        """Return the facts for the report."""
        names = ("kind", "scale_px", "scale_from", "pitch_mm", "pitch_from", "inverted", "inverted_from", "fov")
        facts = {name: getattr(self.scale, name) for name in (*names, "fov_from", "distance_mm")}
        told = ("values", "values_from", "absolute", "unit_from", "preset", "preset_from", "lens")
        facts |= {name: getattr(self.meaning, name) for name in told}
        low, high = self.in_use
        return {
            **facts,
            "unit": None if self.meaning.unit is None else str(self.meaning.unit),
            "bits": self.grey.bits,
            "lowest_value": low,
            "highest_value": high,
            "used_share": None if self.grey.is_float else (high - low) / self.grey.top,
            "step_px": self.step_px,
            "noise_px": self.noise_px,
            "empty": dict(self.grey.empty),
            "fill_px": self.fill_px,
            "filled_pixels": 0 if self.filled is None else int(self.filled.sum()),
            "filled_holes": self.holes,
            "orientation": self.orientation,
            "notes": self.image.notes,
        }


def read_source(image: RasterImage, options: DepthOptions, mask: Float32 | None) -> DepthSource:
    """Return the heights of a picture, scaled by the options, the file, the preset or the default."""
    orientation, image = image.orientation, image.upright()
    meaning = meaning_of(image, options)
    grey, cover = _surface(image, meaning, options, mask, orientation)
    source = _scaled(image, grey, meaning, options, grey, extremes(grey.values, grey.known))
    return _without_holes(replace(source, cover=cover, orientation=orientation), options)


def settled_source(
    image: RasterImage, grey: GreyValues, meaning: Meaning, options: DepthOptions, ends: tuple[float, float]
) -> DepthSource:
    """Return the heights of a sample of a large picture, whose lowest and highest values are known; holes stay.

    Raises
    ------
    InputError, UsageError
        As `read_source`.
    """
    seen = extremes(grey.values, grey.known)
    whole = grey
    if seen != ends:  # the scale follows from the range of the whole picture
        values = np.append(grey.values[grey.known], np.array(ends, np.float32))[None]
        whole = replace(grey, values=values, known=np.ones(values.shape, bool), dropouts=None)
    return _scaled(image, replace(grey, values=grey.values.copy()), meaning, options, whole, ends)


def _scaled(
    image: RasterImage,
    grey: GreyValues,
    meaning: Meaning,
    options: DepthOptions,
    whole: GreyValues,
    in_use: tuple[float, float],
) -> DepthSource:
    """Return the source with the scale of ``whole``; the values of ``grey`` become heights, in place."""
    scale = settle_scale(image, whole, meaning, options)
    step = step_of(grey)
    size = abs(scale.px_per_value)
    most = size * max(map(abs, in_use))
    if most > _MOST_PX:
        raise InputError(
            f"{image.name}: has heights of {most:.3g} px, which cannot be computed with; give the values that mean "
            '"no depth" with `empty`, or check `unit`, `width` and `depth_scale`'
        )
    noise = noise_of(grey.values, grey.known, step)
    noise = noise if noise * size >= FINE_SLOPE else 0.0
    heights = grey.values
    heights *= np.float32(scale.px_per_value)
    lowest = min(float(np.float32(end) * np.float32(scale.px_per_value)) for end in in_use)
    return DepthSource(image, grey, None, meaning, scale, heights, lowest, step * size, noise * size, in_use)


def largest_hole(frame: Frame) -> float:
    """Width in px of the largest hole that is filled by itself."""
    return max(_HOLE_PX, _HOLE_SHARE * frame.longer_side)


def _surface(
    image: RasterImage, meaning: Meaning, options: DepthOptions, given: Float32 | None, orientation: int
) -> tuple[GreyValues, Float32 | None]:
    """Return the grey values of the surface and its coverage (None: 1 where values are known)."""
    if given is not None:
        turned = f", turned upright by its EXIF orientation {orientation}," if orientation != 1 else ""
        check_sizes(f"{image.name}{turned}", image.frame.shape, {"the mask": given.shape})
    named = meaning.empty if options.empty == "auto" else options.empty_values
    grey = depths_of(image, grey_values(image, named), meaning, options)
    cover = image.alpha
    if given is not None:
        known = grey.known & (given > 0)
        if not (known & (given >= 0.5)).any():
            raise InputError("the mask selects no part of the picture: paint the motif white (0.5 or more) on black")
        cover = given if cover is None else cover * given
        dropouts = None if grey.dropouts is None else grey.dropouts & (given > 0)
        grey = replace(grey, known=known, dropouts=dropouts)
    return grey, cover


def _without_holes(source: DepthSource, options: DepthOptions) -> DepthSource:
    """Return the source with small holes filled."""
    grey, image, cover = source.grey, source.image, source.cover
    dropouts = grey.dropouts
    if isinstance(options.fill, Length):
        most = in_px(options.fill, image.frame.cols, source.scale.pitch_mm, "fill", image.name)
        dropouts = ~grey.known if cover is None else ~grey.known & (cover > 0)
    elif options.fill == "none" or dropouts is None or kind_of(image) != "grey":  # such files have no holes by accident
        return source
    else:
        most = largest_hole(image.frame)
    if not dropouts.any():
        return source
    found = fill_holes(source.heights, grey.known, dropouts, most, source.least_jump_px)
    if found.too_large and isinstance(options.fill, Length):
        raise LimitError(
            f"`fill='{options.fill}'`: a hole of {image.name} has {found.too_large} pixels; at most {MOST_PIXELS} are "
            "filled; give a smaller `fill`, or fill it in the program that wrote the picture"
        )
    if found.pixels is None:
        return replace(source, fill_px=most)
    grey = replace(grey, known=grey.known | found.pixels, nothing=grey.nothing - int(found.pixels.sum()))
    return replace(source, grey=grey, heights=found.heights, fill_px=most, filled=found.pixels, holes=found.count)

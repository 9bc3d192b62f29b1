"""The heights of a depth or height picture, and how accurate they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.depth.scale import Scale, settle_scale, without_empty
from nmaptool.depth.values import GreyValues, grey_values, noise_of, step_of
from nmaptool.options import DepthOptions
from nmaptool.types.picture import RasterImage
from nmaptool.types.plain_arrays import check_sizes

# least noise of a lossy file near edges, in steps
_LOSSY_NOISE = 1.25
# with smaller errors of the slopes, no fit is needed
FINE_SLOPE = 0.012


@dataclass(frozen=True, eq=False)
class DepthSource:
    """The heights of a picture in px, with their scale, step and noise."""

    image: RasterImage
    grey: GreyValues
    cover: Float32 | None
    scale: Scale
    heights: Float32
    lowest: float
    step_px: float
    noise_px: float

    @property
    def unsure(self) -> float:
        """Least noise of heights near edges, in px; 0 in clean pictures."""
        return max(_LOSSY_NOISE * self.step_px if self.image.lossy else 0.0, self.noise_px)

    def facts(self) -> dict[str, Any]:
        """Return the facts for the report."""
        names = ("kind", "scale_px", "scale_from", "pitch_mm", "inverted", "inverted_from", "fov", "fov_from")
        facts = {name: getattr(self.scale, name) for name in names}
        return {**facts, "bits": self.grey.bits, "step_px": self.step_px, "noise_px": self.noise_px}


def read_source(image: RasterImage, options: DepthOptions, mask: Float32 | None) -> DepthSource:
    """Return the heights of a picture, scaled by the options, the file or the default."""
    grey, cover = _surface(image, options, mask)
    scale = settle_scale(image, grey, options)
    step = step_of(grey)
    size = abs(scale.px_per_value)
    noise = noise_of(grey.values, grey.known, step)
    noise = noise if noise * size >= FINE_SLOPE else 0.0
    heights = grey.values
    heights *= np.float32(scale.px_per_value)  # the values are a copy
    return DepthSource(image, grey, cover, scale, heights, extremes(heights, grey.known)[0], step * size, noise * size)


def extremes(heights: Float32, known: Mask) -> tuple[float, float]:
    """Return the lowest and the highest known height."""
    if known.all():  # several times faster
        return float(heights.min()), float(heights.max())
    return float(heights.min(where=known, initial=np.inf)), float(heights.max(where=known, initial=-np.inf))


def _surface(image: RasterImage, options: DepthOptions, given: Float32 | None) -> tuple[GreyValues, Float32 | None]:
    """Return the grey values of the surface and its coverage (None: 1 where values are known)."""
    if given is not None:
        check_sizes(image.name, image.frame.shape, {"the mask": given.shape})
    grey = without_empty(image, grey_values(image), options)
    cover = image.alpha
    if given is not None:
        known = grey.known & (given > 0)
        if not (known & (given >= 0.5)).any():
            raise InputError("the mask selects no part of the picture: paint the motif white (0.5 or more) on black")
        cover = given if cover is None else cover * given
        grey = GreyValues(grey.values, known, grey.top, grey.is_float, grey.bits, grey.noisy_grey, grey.nothing)
    return grey, cover

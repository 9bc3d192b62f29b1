"""The camera of a depth picture: its field of view, the value at the eye, and the size of a pixel at the distances."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import Length
from nmaptool.depth.meaning import Meaning, kind_of
from nmaptool.depth.values import INFINITE, GreyValues
from nmaptool.options import DepthOptions
from nmaptool.options.depth import NARROWEST_FOV, WIDEST_FOV
from nmaptool.types.picture import RasterImage


def fov_of(image: RasterImage, options: DepthOptions) -> tuple[float, str]:
    """Return the field of view in degrees across the longer side and its source: ``given``, ``file`` or ``assumed``.

    Raises
    ------
    UsageError
        If a field of view is given for heights, or the focal length is too short or too long.
    """
    facts = image.depth_facts
    if options.fov is not None:
        if options.fov and facts is not None and facts.kind == "height":
            raise UsageError(f"`fov`: {image.name} holds heights, which have no perspective; leave it out")
        return _degrees(image, options.fov), "given"
    if facts is None or facts.fov_deg is None or not NARROWEST_FOV <= facts.fov_deg <= WIDEST_FOV:
        return 0.0, "assumed"
    return facts.fov_deg, "file"


def _degrees(image: RasterImage, given: float | Length) -> float:
    if not isinstance(given, Length):
        return given
    side = image.frame.longer_side
    fov = math.degrees(2 * math.atan(side / (2 * given.value)))
    if not NARROWEST_FOV <= fov <= WIDEST_FOV:
        raise UsageError(
            f"`fov='{given}'`: a focal length of {given.value:g} px gives {fov:.3g} degrees across {side} px; must lie "
            f"between {NARROWEST_FOV:g} and {WIDEST_FOV:g} degrees"
        )
    return fov


def focal_px(image: RasterImage, fov: float) -> float:
    """Return the distance from the eye to the picture plane in px; infinite if orthographic."""
    return image.frame.longer_side / (2 * math.tan(math.radians(fov) / 2)) if fov else math.inf


def measured_eye(
    image: RasterImage, grey: GreyValues, options: DepthOptions, meaning: Meaning, mm_per_value: float | None
) -> float | None:
    """Return the stored value at the eye if depths are measured from the eye; None if only differences are known.

    Raises
    ------
    InputError
        If a depth is not in front of the eye.
    """
    is_own_code = kind_of(image) == "depth" and not grey.is_float
    if options.depth_scale is not None or not (is_own_code or (meaning.is_distance and meaning.absolute)):
        return None
    eye = 0.0
    if is_own_code:
        facts = image.depth_facts
        if not mm_per_value or facts is None or facts.white_mm is None:
            return None
        eye = grey.top + facts.white_mm / mm_per_value
    nearest = eye - grey.top if is_own_code else float(grey.values.min(where=grey.known, initial=np.inf))
    if nearest <= 1 / INFINITE:
        raise InputError(
            f"{image.name}: has a depth of {nearest:g}; with `fov`, depths are distances from the eye and must be "
            "greater than 0"
        )
    return eye


def check_in_front(scale_px: float, focal: float, fov: float, options: DepthOptions) -> None:
    """Raise an error if white would be behind the camera."""
    if scale_px >= focal:
        name = "depth_scale" if options.unit is None else "unit"
        remedy = "use a smaller `depth_scale`" if options.unit is None else "check `unit` and `width`"
        raise UsageError(
            f"`{name}`: white is {scale_px:.4g} px in front of black, but with `fov={fov:g}` the camera is only "
            f"{focal:.4g} px away; {remedy}"
        )

"""Convert stored grey values to heights in pixels: which end is near, the distance of the ends, and the camera."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import Length
from nmaptool.depth.values import GreyValues, empty_depths
from nmaptool.options import DepthOptions
from nmaptool.options.depth import NARROWEST_FOV, WIDEST_FOV
from nmaptool.types.picture import RasterImage

DEFAULT_SHARE = Length(10.0, "%")
_SAMPLE = 1 << 17


@dataclass(frozen=True)
class Scale:
    """The conversion of stored values to heights, and the sources of its parameters.

    Attributes
    ----------
    px_per_value : float
        Height in px per stored unit; negative if dark or small is near.
    scale_px : float
        Height of white above black, or of the highest above the lowest float, in px.
    scale_from : str
        ``given``, ``file`` or ``assumed``.
    inverted : bool
    inverted_from : str
        ``given``, ``file`` or ``assumed``.
    kind : str
        ``depth`` or ``height`` if the file declares it, else ``grey``.
    pitch_mm : float or None
        Millimetres per pixel.
    fov : float
        Field of view across the longer side, in degrees; 0 if orthographic.
    fov_from : str
        ``given``, ``file`` or ``assumed``.
    distance_px : float
        Distance from the eye to the picture plane; infinite if orthographic.
    eye_value : float
        Stored value at the eye of a perspective camera.
    """

    px_per_value: float
    scale_px: float
    scale_from: str
    inverted: bool
    inverted_from: str
    kind: str
    pitch_mm: float | None
    fov: float
    fov_from: str
    distance_px: float
    eye_value: float


def in_px(length: Length, cols: int, pitch_mm: float | None, field: str, name: str) -> float:
    """Return a height in px; % means percent of the picture's width.

    Raises
    ------
    UsageError
        If it is in mm and the pitch is unknown.
    """
    if length.is_absolute:
        if pitch_mm is None:
            raise UsageError(
                f"`{field}='{length}'`: the size of a pixel in {name} is not known; give px or %, or the `width` of "
                "the picture"
            )
        return length.to_mm(1.0, 1) / pitch_mm
    return length.to_mm(1.0, cols)


def settle_scale(image: RasterImage, grey: GreyValues, options: DepthOptions) -> Scale:
    """Return the scale of a picture's heights from the options, the file or the default.

    Raises
    ------
    UsageError
        If a length is in mm and the pitch is unknown, or ``invert`` contradicts the file.
    InputError
        If the range in the file is damaged, or depths are not in front of a perspective camera.
    """
    kind = kind_of(image)
    if kind != "grey" and options.invert:
        raise UsageError(
            f"`invert`: {image.name} declares that it holds {kind}, which fixes the direction; leave it out"
        )
    cols = image.frame.cols
    pitch = options.width.to_mm(1.0, 1) / cols if options.width is not None else image.frame.pitch_mm
    black, white, mm_per_value = _range(image, grey)
    fov, fov_from = _fov(image, options)
    inverted = options.invert or (kind == "depth" and grey.is_float)
    focal = image.frame.longer_side / (2 * math.tan(math.radians(fov) / 2)) if fov else math.inf
    eye = _measured_eye(image, grey, options, inverted, mm_per_value) if fov else None
    if options.depth_scale is not None:
        scale_px, source = in_px(options.depth_scale, cols, pitch, "depth_scale", image.name), "given"
    elif eye is not None:  # only ratios of depths are known: magnification 1 at the median depth
        middle = float(np.median(grey.values[grey.known][:: max(1, grey.values.size // _SAMPLE)]))
        scale_px, source = abs(white - black) * focal / abs(eye - middle), "file"
    elif mm_per_value is not None:
        if pitch is None:
            raise UsageError(
                f"{image.name}: holds {kind} in mm, but the size of a pixel is not known; give the `width` of the "
                "picture"
            )
        scale_px, source = (white - black) * mm_per_value / pitch, "file"
    else:
        scale_px, source = in_px(DEFAULT_SHARE, cols, pitch, "depth_scale", image.name), "assumed"
    per_value = scale_px / (white - black) if white > black else 0.0
    per_value = -per_value if inverted else per_value
    if fov and eye is None and per_value:
        _check_in_front(scale_px, focal, fov)
        eye = (white if inverted else black) + focal / per_value
    inverted_from = "file" if kind != "grey" else "given" if options.invert else "assumed"
    return Scale(per_value, scale_px, source, inverted, inverted_from, kind, pitch, fov, fov_from, focal, eye or 0.0)


def kind_of(image: RasterImage) -> str:
    """Return ``depth`` or ``height`` if the file declares it, else ``grey``."""
    return "grey" if image.depth_facts is None else image.depth_facts.kind


def _check_in_front(scale_px: float, focal: float, fov: float) -> None:
    """Raise an error if white would be behind the camera."""
    if scale_px >= focal:
        raise UsageError(
            f"`depth_scale`: white is {scale_px:.4g} px in front of black, but with `fov={fov:g}` the camera is only "
            f"{focal:.4g} px away; use a smaller `depth_scale`"
        )


def _fov(image: RasterImage, options: DepthOptions) -> tuple[float, str]:
    """Return the field of view in degrees across the longer side and its source: the option, else the file."""
    facts = image.depth_facts
    if options.fov is not None:
        if options.fov and facts is not None and facts.kind == "height":
            raise UsageError(f"`fov`: {image.name} holds heights, which have no perspective; leave it out")
        return options.fov, "given"
    if facts is None or facts.fov_deg is None or not NARROWEST_FOV <= facts.fov_deg <= WIDEST_FOV:
        return 0.0, "assumed"
    return facts.fov_deg, "file"


def _measured_eye(
    image: RasterImage, grey: GreyValues, options: DepthOptions, inverted: bool, mm_per_value: float | None
) -> float | None:
    """Return the stored value at the eye if depths are measured from the eye; None if only differences are known.

    Raises
    ------
    InputError
        If a depth is not in front of the eye.
    """
    is_depth = kind_of(image) == "depth" or (grey.is_float and inverted)
    if options.depth_scale is not None or not is_depth:
        return None
    eye = 0.0
    if not grey.is_float:
        facts = image.depth_facts
        if not mm_per_value or facts is None or facts.white_mm is None:
            return None
        eye = grey.top + facts.white_mm / mm_per_value
    nearest = float(grey.values.min(where=grey.known, initial=np.inf)) if inverted else eye - grey.top
    if nearest <= 0:
        raise InputError(
            f"{image.name}: has a depth of {nearest:g}; with `fov`, depths are distances from the eye and must be "
            "greater than 0"
        )
    return eye


def _range(image: RasterImage, grey: GreyValues) -> tuple[float, float, float | None]:
    """Return the values of black and white, and the millimetres per stored unit if the file states them."""
    facts = image.depth_facts
    if facts is not None and not grey.is_float:
        if facts.black_mm is None or facts.white_mm is None:
            raise InputError(
                f"{image.name}: declares that it holds {facts.kind}, but not its range; export it again as EXR, or "
                "remove that metadata and give `depth_scale`"
            )
        return 0.0, grey.top, abs(facts.white_mm - facts.black_mm) / grey.top
    if not grey.is_float:
        return 0.0, grey.top, None
    low = float(grey.values.min(where=grey.known, initial=np.inf))
    high = float(grey.values.max(where=grey.known, initial=-np.inf))
    if facts is None and low >= 0 and high <= 1:
        return 0.0, 1.0, None
    return low, high, None if facts is None else 1.0


def magnification(heights: Float32, scale: Scale) -> Float32 | None:
    """Return the (H, W) float32 factor of slopes in perspective, camera distance over depth; None if orthographic.

    Parameters
    ----------
    heights : (H, W) float32
        Stored values times ``scale.px_per_value``.
    scale : Scale
    """
    if not scale.fov or not scale.px_per_value:
        return None
    depth = np.float32(scale.eye_value * scale.px_per_value) - heights
    # unknown pixels may have any height
    np.maximum(depth, np.float32(1e-3 * scale.distance_px), out=depth)
    np.divide(np.float32(scale.distance_px), depth, out=depth)
    return depth


def without_empty(image: RasterImage, grey: GreyValues, options: DepthOptions) -> GreyValues:
    """Return the values without those that mean "empty" in a float picture of depths.

    Raises
    ------
    InputError
        If no value remains.
    """
    kind = kind_of(image)
    is_depth = kind == "depth" or (kind == "grey" and options.invert)
    if not grey.is_float or not is_depth or options.background == "none":
        return grey
    empty = empty_depths(grey.values, grey.known)
    if not empty.any():
        return grey
    known = grey.known & ~empty
    if not known.any():
        raise InputError(f"{image.name}: no pixel has a depth greater than 0")
    values = np.where(empty, np.float32(0), grey.values)
    return GreyValues(
        values, known, grey.top, grey.is_float, grey.bits, grey.noisy_grey, grey.nothing + int(np.count_nonzero(empty))
    )

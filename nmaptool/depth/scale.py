"""Stored grey values to heights in pixels: which end is near, how far apart the ends are, and how the camera saw it."""

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
    """How stored values become heights, and from what it was decided.

    Attributes
    ----------
    px_per_value : float
        Height in px to one stored unit; negative where dark or small is near.
    scale_px : float
        How far white stands above black, or the highest above the lowest float.
    scale_from : str
        ``given``, ``file`` or ``assumed``.
    inverted : bool
    inverted_from : str
        ``given``, ``file`` or ``assumed``.
    kind : str
        ``depth`` or ``height`` where the file says so, else ``grey``.
    pitch_mm : float or None
        Size of a pixel.
    fov : float
        Degrees across the longer side; 0 where orthographic.
    fov_from : str
        ``given``, ``file`` or ``assumed``.
    distance_px : float
        From the eye to the picture plane; infinite where orthographic.
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
    """A height in px; % is of the picture's width.

    Raises
    ------
    UsageError
        If it is in mm and the size of a pixel is not known.
    """
    if length.is_absolute:
        if pitch_mm is None:
            raise UsageError(
                f"`{field}='{length}'`: {name} does not say how large a pixel is; "
                "give px or %, or the picture's `width`"
            )
        return length.to_mm(1.0, 1) / pitch_mm
    return length.to_mm(1.0, cols)


def settle_scale(image: RasterImage, grey: GreyValues, options: DepthOptions) -> Scale:
    """What the options, the file or the default say of a picture's heights.

    Raises
    ------
    UsageError
        If a length in mm has no pixel to measure it with, or --invert contradicts the file.
    InputError
        If the file's own account of its range is damaged, or depths do not fit a perspective camera.
    """
    kind = kind_of(image)
    if kind != "grey" and options.invert:
        raise UsageError(f"`invert`: {image.name} says itself that it holds {kind}; leave it out")
    cols = image.frame.cols
    pitch = options.width.to_mm(1.0, 1) / cols if options.width is not None else image.frame.pitch_mm
    black, white, mm_per_value = _range(image, grey)
    fov, fov_from = _fov(image, options)
    inverted = options.invert or (kind == "depth" and grey.is_float)
    focal = image.frame.longer_side / (2 * math.tan(math.radians(fov) / 2)) if fov else math.inf
    eye = _measured_eye(image, grey, options, inverted, mm_per_value) if fov else None
    if options.depth_scale is not None:
        scale_px, source = in_px(options.depth_scale, cols, pitch, "depth_scale", image.name), "given"
    elif eye is not None:  # only the ratios of depths count: life-size in the middle
        middle = float(np.median(grey.values[grey.known][:: max(1, grey.values.size // _SAMPLE)]))
        scale_px, source = abs(white - black) * focal / abs(eye - middle), "file"
    elif mm_per_value is not None:
        if pitch is None:
            raise UsageError(
                f"{image.name}: holds {kind} in mm but does not say how large a pixel is; give the picture's `width`"
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
    """``depth`` or ``height`` where the file says so, else ``grey``."""
    return "grey" if image.depth_facts is None else image.depth_facts.kind


def _check_in_front(scale_px: float, focal: float, fov: float) -> None:
    """Refuse a white that would stand behind the camera."""
    if scale_px >= focal:
        raise UsageError(
            f"`depth_scale`: white would stand {scale_px:.4g} px in front of black, behind a camera of `fov` "
            f"{fov:g} that is {focal:.4g} px away; use a smaller one"
        )


def _fov(image: RasterImage, options: DepthOptions) -> tuple[float, str]:
    """Degrees across the longer side: as given, else those of the camera that a file of depths was drawn with."""
    facts = image.depth_facts
    if options.fov is not None:
        if options.fov and facts is not None and facts.kind == "height":
            raise UsageError(f"`fov`: {image.name} holds heights, which no camera sees in perspective; leave it out")
        return options.fov, "given"
    if facts is None or facts.fov_deg is None or not NARROWEST_FOV <= facts.fov_deg <= WIDEST_FOV:
        return 0.0, "assumed"
    return facts.fov_deg, "file"


def _measured_eye(
    image: RasterImage, grey: GreyValues, options: DepthOptions, inverted: bool, mm_per_value: float | None
) -> float | None:
    """The stored value at the eye, where depths are measured from there; None where only their differences count.

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
            f"{image.name}: holds a depth of {nearest:g}, which a camera with `fov` cannot see; depths count from the "
            "eye and are greater than 0"
        )
    return eye


def _range(image: RasterImage, grey: GreyValues) -> tuple[float, float, float | None]:
    """Values of black and white, and millimetres to a stored unit where the file says it."""
    facts = image.depth_facts
    if facts is not None and not grey.is_float:
        if facts.black_mm is None or facts.white_mm is None:
            raise InputError(
                f"{image.name}: says that it holds {facts.kind} but not from where to where; write it again as EXR, or "
                "save it without that note and give `depth_scale`"
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
    """(H, W) float32 factor of slopes that a perspective camera makes: its distance over the depth; None without one.

    Parameters
    ----------
    heights : (H, W) float32
        Stored values times ``scale.px_per_value``.
    scale : Scale
    """
    if not scale.fov or not scale.px_per_value:
        return None
    depth = np.float32(scale.eye_value * scale.px_per_value) - heights
    # unknown pixels may lie anywhere
    np.maximum(depth, np.float32(1e-3 * scale.distance_px), out=depth)
    np.divide(np.float32(scale.distance_px), depth, out=depth)
    return depth


def without_empty(image: RasterImage, grey: GreyValues, options: DepthOptions) -> GreyValues:
    """The values without those that stand for nothing in a float picture of depths.

    Raises
    ------
    InputError
        If nothing is left.
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

"""Convert stored values to heights in pixels: which end is near, the distance of the ends, and the size of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import Length
from nmaptool.depth.camera import check_in_front, focal_px, fov_of, measured_eye
from nmaptool.depth.empty import middle_of
from nmaptool.depth.meaning import Meaning, kind_of
from nmaptool.depth.values import INFINITE, GreyValues, extremes
from nmaptool.options import DepthOptions
from nmaptool.types.picture import RasterImage

DEFAULT_SHARE = Length(10.0, "%")
# if a picture uses a smaller share of its codes, the default scale is that of the codes in use
_SMALL_SHARE = 0.1


@dataclass(frozen=True)
class Scale:
    """The conversion of stored values to heights, and the sources of its parameters.

    Attributes
    ----------
    px_per_value : float
        Height in px per stored unit; negative if dark or small is near.
    scale_px : float
        Height of white above black, or of the highest above the lowest value in use, in px.
    scale_from : str
        ``given``, ``file``, ``unit``, ``fov`` (from the distances themselves), ``range`` (assumed for the values in
        use) or ``assumed``.
    inverted : bool
    inverted_from : str
        ``given``, ``file``, ``preset``, ``found`` or ``assumed``.
    kind : str
        ``depth`` or ``height`` if the file declares it, else ``grey``.
    pitch_mm : float or None
        Millimetres per pixel.
    pitch_from : str
        ``given``, ``file``, ``depth`` (from the field of view at the median distance) or ``none``.
    fov : float
        Field of view across the longer side, in degrees; 0 if orthographic.
    fov_from : str
        ``given``, ``file`` or ``assumed``.
    distance_px : float
        Distance from the eye to the picture plane; infinite if orthographic.
    eye_value : float
        Stored value at the eye of a perspective camera.
    distance_mm : float or None
        Median distance, if it is known.
    """

    px_per_value: float
    scale_px: float
    scale_from: str
    inverted: bool
    inverted_from: str
    kind: str
    pitch_mm: float | None
    pitch_from: str
    fov: float
    fov_from: str
    distance_px: float
    eye_value: float
    distance_mm: float | None = None


@dataclass(frozen=True)
class _Ends:
    """The values of black and white, whether they are those in use, and the millimetres per stored unit if known."""

    black: float
    white: float
    in_use: bool = False
    mm_per_value: float | None = None

    @property
    def span(self) -> float:
        return self.white - self.black


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


def settle_scale(image: RasterImage, grey: GreyValues, meaning: Meaning, options: DepthOptions) -> Scale:
    """Return the scale of a picture's heights from the options, the file, the preset or the default.

    Raises
    ------
    UsageError
        If a length is in mm and the pitch is unknown.
    InputError
        If the range in the file is damaged, or depths are not in front of a perspective camera.
    """
    cols = image.frame.cols
    pitch, pitch_from = _pitch(image, options)
    ends = _ends_of(image, grey, meaning, options)
    fov, fov_from = fov_of(image, options)
    # integer codes of a file that declares depths have white near
    inverted = meaning.is_distance and (kind_of(image) == "grey" or grey.is_float)
    focal = focal_px(image, fov)
    eye = measured_eye(image, grey, options, meaning, ends.mm_per_value) if fov else None
    middle_mm = None
    if options.depth_scale is not None:
        scale_px, source = in_px(options.depth_scale, cols, pitch, "depth_scale", image.name), "given"
    elif eye is not None:  # only ratios of depths are known: magnification 1 at the median depth
        middle = abs(eye - middle_of(grey))
        scale_px = abs(ends.span) * focal / middle
        source = "file" if kind_of(image) != "grey" else "fov" if meaning.unit is None else "unit"
        if meaning.unit is not None:
            middle_mm = middle * meaning.unit.to_mm(1.0, 1)
            pitch, pitch_from = (middle_mm / focal, "depth") if pitch is None else (pitch, pitch_from)
    elif ends.mm_per_value is not None and (pitch is not None or meaning.unit_from != "preset"):
        scale_px, source = ends.span * ends.mm_per_value / _needed(pitch, image, meaning), "file"
        source = source if meaning.unit is None else "unit"
    else:
        scale_px = in_px(DEFAULT_SHARE, cols, pitch, "depth_scale", image.name)
        source = "range" if ends.in_use else "assumed"
    per_value = scale_px / ends.span if ends.span > 1 / INFINITE else 0.0  # no overflow
    per_value = -per_value if inverted else per_value
    if fov and eye is None and per_value:
        check_in_front(scale_px, focal, fov, options)
        eye = (ends.white if inverted else ends.black) + focal / per_value
    return Scale(
        per_value,
        scale_px,
        source,
        inverted,
        meaning.values_from,
        kind_of(image),
        pitch,
        pitch_from,
        fov,
        fov_from,
        focal,
        eye or 0.0,
        middle_mm,
    )


def _pitch(image: RasterImage, options: DepthOptions) -> tuple[float | None, str]:
    """Return the size of a pixel from the options or the file, and its source."""
    if options.width is not None:
        return options.width.to_mm(1.0, 1) / image.frame.cols, "given"
    return image.frame.pitch_mm, "none" if image.frame.pitch_mm is None else "file"


def _needed(pitch: float | None, image: RasterImage, meaning: Meaning) -> float:
    """Return the size of a pixel, which values in mm need."""
    if pitch is not None:
        return pitch
    if meaning.unit is None:
        raise UsageError(
            f"{image.name}: holds {kind_of(image)} in mm, but the size of a pixel is not known; give the `width` of "
            "the picture"
        )
    lens = ", or the `fov` of the camera" if meaning.is_distance else ""
    raise UsageError(
        f"`unit='{meaning.unit}'`: the size of a pixel in {image.name} is not known; give the `width` of the picture"
        f"{lens}"
    )


def _ends_of(image: RasterImage, grey: GreyValues, meaning: Meaning, options: DepthOptions) -> _Ends:
    """Return the values of black and white: all codes, or those in use if these are few or distances are known."""
    facts = image.depth_facts
    if facts is not None and not grey.is_float:
        if facts.black_mm is None or facts.white_mm is None:
            raise InputError(
                f"{image.name}: declares that it holds {facts.kind}, but not its range; export it again as EXR, or "
                "remove that metadata and give `depth_scale`"
            )
        return _Ends(0.0, grey.top, False, abs(facts.white_mm - facts.black_mm) / grey.top)
    mm = 1.0 if facts is not None else None if meaning.unit is None else meaning.unit.to_mm(1.0, 1)
    low, high = extremes(grey.values, grey.known)
    if not grey.is_float:
        share = (high - low) / grey.top
        in_use = mm is not None or (
            options.depth_scale is None and share > 0 and (share < _SMALL_SHARE or bool(grey.empty))
        )
        return _Ends(low, high, True, mm) if in_use else _Ends(0.0, grey.top)
    has_white = meaning.values_from == "assumed" or options.invert or not meaning.absolute
    normalised = has_white and low >= 0 and high <= 1
    if facts is None and mm is None and normalised:
        in_use = options.depth_scale is None and 0 < high - low < _SMALL_SHARE
        return _Ends(low, high, True) if in_use else _Ends(0.0, 1.0)
    return _Ends(low, high, False, mm)


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

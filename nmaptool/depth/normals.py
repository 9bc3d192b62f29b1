"""A depth or height picture to normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress, Stages
from nmaptool.depth.fit import fit_surface
from nmaptool.depth.ground import find_ground
from nmaptool.depth.jumps import Surfaces, join_all, part_surfaces
from nmaptool.depth.outlines import continue_to_jumps
from nmaptool.depth.rim import narrow_tolerance, widen_tolerance
from nmaptool.depth.scale import Scale, in_px, magnification, settle_scale, without_empty
from nmaptool.depth.slopes import jump_sizes, mean_curl, normals_of
from nmaptool.depth.steps import JumpRule
from nmaptool.depth.values import GreyValues, grey_values, noise_of, step_of
from nmaptool.options import DepthOptions
from nmaptool.types.depth import DepthReport, DepthResult
from nmaptool.types.inputs import MaskLike, RasterLike, as_raster
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.plain_arrays import as_mask, check_sizes

# a jump is this high at least: in px, in steps of the codes, and in deviations of the noise
_JUMP_PX, _JUMP_STEPS, _JUMP_NOISE = 1.0, 4.0, 7.0
# a pixel of a smoothed outline is off its side by so much at least: in px, in steps
_MIXED_PX, _MIXED_STEPS = 0.02, 2.0
# how far the surface may leave the stored heights: half a step, and the noise; lossy files are off by more than that
_NOISE_REACH, _LOSSY_STEPS = 3.0, 1.5
# steps of descent, more where the surface may leave the heights by more than so many of the steps they hold
_LEAST_DESCENT, _MOST_DESCENT, _THOROUGH_STEPS = 10, 40, 0.6
# pictures of more pixels than this get fewer steps: their forms bend less from pixel to pixel
_FULL_DESCENT_PIXELS = 1e6
# pixels beside a line of jumps: a motif of one pixel has five, noise often more
_LEAST_LINE, _NOISY_LINE = 5, 12
# noise that a lossy file has near its edges at least, in steps
_LOSSY_NOISE = 1.25
# slopes that are less wrong than this need no fit
_FINE_SLOPE = 0.012


def depth_to_normals(
    image: RasterLike,
    options: DepthOptions | None = None,
    *,
    mask: MaskLike | None = None,
    progress: Progress | None = None,
) -> DepthResult:
    """Turn a depth or height picture into a normal map.

    Jumps, where one part hides another, are detected, and no slope is taken across them. Stepped or noisy heights are
    fitted by the smoothest surface within their tolerance; clean heights are differenced.

    Parameters
    ----------
    image : RasterImage, or (H, W) uint8, uint16 or float
        Grey: integer codes or floats, see `nmaptool.read_raster`. NaN and infinite values mean that there is no depth.
    options : DepthOptions, optional
        Which way is near, the scale of the values, jumps, smoothing, background.
    mask : (H, W) bool or float in [0, 1], optional
        Where the surface is: becomes the coverage. Pixels outside are ignored.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    DepthResult
        The normal map, the height of jumps in px, and the report.

    Raises
    ------
    InputError
        If the picture is coloured or empty, or the mask does not fit or selects nothing.
    UsageError
        If a length in mm needs a pixel's size that is not known, an option contradicts what the file says, or the
        picture is neither a RasterImage nor an array.

    Examples
    --------
    Heights of half a pixel a pixel to the right, given in px:

    >>> heights = 0.5 * np.arange(16) + np.zeros((16, 1))
    >>> options = nm.DepthOptions(depth_scale=nm.length("7.5px"), background="none")
    >>> normals = nm.depth_to_normals(heights, options).normal_map.normals
    >>> (-normals[8, 8, :2] / normals[8, 8, 2]).round(3).tolist()
    [0.5, -0.0]
    """
    options = options or DepthOptions()
    stages = Stages(progress)
    with stages.stage("reading", 0.0):
        source = _read(as_raster(image), options, None if mask is None else as_mask(mask))
        heights, known, scale = source.heights, source.grey.known, source.scale
        rule = _rule(options, source)
    with stages.stage("jumps", 0.2):
        parts = part_surfaces(heights, known, rule) if rule is not None else Surfaces(heights, *join_all(known))
        heights, across, down = parts.heights, parts.across, parts.down
        jumps = jump_sizes(heights, known, across, down)
    with stages.stage("surface", 0.4):
        tolerance = _tolerance(options, source)
        slack = np.full(heights.shape, tolerance, np.float32)
        if source.unsure:
            widen_tolerance(slack, jumps)
        elif rule is not None and parts.mixed and tolerance:
            np.copyto(slack, rule.least_mixed, where=jumps > 0)
        if tolerance and not source.unsure:
            narrow_tolerance(slack, heights, jumps)
        ground, word = _ground(options, source, heights, slack)
        if tolerance:
            heights = fit_surface(heights, slack, across, down, _descent(tolerance, source))
        del slack
    with stages.stage("normals", 0.8):
        flat = ground if known.all() else ~known if ground is None else ground | ~known
        factor = magnification(heights, scale)
        normals = normals_of(heights, across, down, flat, fine=not tolerance, factor=factor)
        continue_to_jumps(normals, across, down, flat, clean=not tolerance)
        lowest, highest = _ends(heights, known)
        del heights, across, down, factor, flat
        normal_map = _map(source, normals, ground, word)
    beside = int(np.count_nonzero(jumps))
    with stages.stage("curl", 0.9):
        turn = mean_curl(normal_map.normals, normal_map.foreground)
    report = DepthReport(
        options=options,
        **source.facts(),
        range_px=highest - lowest,
        tolerance_px=tolerance,
        jump_px=rule.least if rule is not None else None,
        jumps=beside,
        jump_share=beside / int(np.count_nonzero(known)),
        mixed_pixels=parts.mixed,
        background=word,
        background_share=float(1 - normal_map.foreground.mean()),
        curl=turn,
        seconds=stages.seconds(),
        warnings=normal_map.decoding.warnings,
    )
    return DepthResult(normal_map, jumps, report)


@dataclass(frozen=True, eq=False)
class _Source:
    """A picture's heights in px, and what is known of them."""

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
        """Noise in px that heights near edges have at least; 0 in clean pictures."""
        return max(_LOSSY_NOISE * self.step_px if self.image.lossy else 0.0, self.noise_px)

    def facts(self) -> dict[str, Any]:
        """What the report says of it."""
        names = ("kind", "scale_px", "scale_from", "pitch_mm", "inverted", "inverted_from", "fov", "fov_from")
        facts = {name: getattr(self.scale, name) for name in names}
        return {**facts, "bits": self.grey.bits, "step_px": self.step_px, "noise_px": self.noise_px}


def _read(image: RasterImage, options: DepthOptions, mask: Float32 | None) -> _Source:
    grey, cover = _surface(image, options, mask)
    scale = settle_scale(image, grey, options)
    step = step_of(grey)
    size = abs(scale.px_per_value)
    noise = noise_of(grey.values, grey.known, step)
    noise = noise if noise * size >= _FINE_SLOPE else 0.0
    heights = grey.values
    heights *= np.float32(scale.px_per_value)  # they are a copy of the picture's
    return _Source(image, grey, cover, scale, heights, _ends(heights, grey.known)[0], step * size, noise * size)


def _ends(heights: Float32, known: Mask) -> tuple[float, float]:
    """The lowest and the highest of the known heights."""
    if known.all():  # several times faster
        return float(heights.min()), float(heights.max())
    return float(heights.min(where=known, initial=np.inf)), float(heights.max(where=known, initial=-np.inf))


def _surface(image: RasterImage, options: DepthOptions, given: Float32 | None) -> tuple[GreyValues, Float32 | None]:
    """The grey values where there is a surface, and its coverage (None: all of it is covered where known)."""
    if given is not None:
        check_sizes(image.name, image.frame.shape, {"the mask": given.shape})
    grey = without_empty(image, grey_values(image), options)
    cover = image.alpha
    if given is not None:
        known = grey.known & (given > 0)
        if not (known & (given >= 0.5)).any():
            raise InputError("the mask selects nothing of the picture: paint the motif white (0.5 or more) on black")
        cover = given if cover is None else cover * given
        grey = GreyValues(grey.values, known, grey.top, grey.is_float, grey.bits, grey.noisy_grey, grey.nothing)
    return grey, cover


def _rule(options: DepthOptions, source: _Source) -> JumpRule | None:
    if options.jump == "none":
        return None
    unsure, image = source.unsure, source.image
    mixed = max(_MIXED_PX, _MIXED_STEPS * source.step_px, _JUMP_NOISE / 2 * unsure)
    if options.jump != "auto":
        least = in_px(options.jump, image.frame.cols, source.scale.pitch_mm, "jump", image.name)
        return JumpRule(least, mixed, by_hand=True)
    least = max(_JUMP_PX, _JUMP_STEPS * source.step_px, _JUMP_NOISE * unsure)
    return JumpRule(least, mixed, 2 * unsure, _NOISY_LINE if unsure else _LEAST_LINE)


def _tolerance(options: DepthOptions, source: _Source) -> float:
    image = source.image
    if options.smooth == "none":
        return 0.0
    if options.smooth != "auto":
        return in_px(options.smooth, image.frame.cols, source.scale.pitch_mm, "smooth", image.name)
    if max(source.step_px, source.noise_px) < _FINE_SLOPE:
        return 0.0
    return source.step_px * (_LOSSY_STEPS if image.lossy else 0.5) + _NOISE_REACH * source.noise_px


def _descent(tolerance: float, source: _Source) -> int:
    """Steps of descent that fit a surface."""
    share = (_FULL_DESCENT_PIXELS / source.heights.size) ** 0.5
    most = _MOST_DESCENT if tolerance > _THOROUGH_STEPS * source.step_px else round(_MOST_DESCENT * share)
    return min(max(most, _LEAST_DESCENT), _MOST_DESCENT)


def _ground(options: DepthOptions, source: _Source, heights: Float32, slack: Float32) -> tuple[Mask | None, str]:
    """The flat background, and what kinds of background there are."""
    kinds = ["empty"] if source.grey.nothing else []
    if options.background != "none":
        ground = find_ground(heights, source.lowest, source.grey.known, slack if source.unsure else None)
        if ground.any():
            kinds.append("flat" if options.background == "flat" else "cut")
            return ground, ", ".join(kinds)
    return None, ", ".join(kinds) or "none"


def _map(source: _Source, normals: Float32, ground: Mask | None, word: str) -> NormalMap:
    """The map, its background flat; a background that is cut has no coverage."""
    image, known = source.image, source.grey.known
    coverage = known.astype(np.float32)
    if source.cover is not None:
        coverage *= source.cover
    foreground = coverage >= 0.5
    if ground is not None:
        foreground &= ~ground
        if word.endswith("cut"):
            coverage[ground] = 0
    decoding = Decoding(
        encoding="signed",
        zero_code="0",
        background="flat" if word.endswith("flat") else "none" if word == "none" else "alpha",
        warnings=("its colours differ a little; their mean was taken for grey",) if source.grey.noisy_grey else (),
    )
    frame = Frame(*image.frame.shape, source.scale.pitch_mm)
    return NormalMap(normals, coverage, frame, foreground, image.name, decoding, word.endswith("flat"))

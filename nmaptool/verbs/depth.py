"""A depth or height picture to normals."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.fit import fit_surface
from nmaptool.depth.ground import find_ground
from nmaptool.depth.jumps import Surfaces, join_all, part_surfaces
from nmaptool.depth.report import DepthNormals, DepthReport
from nmaptool.depth.rim import widen_tolerance
from nmaptool.depth.scale import Scale, in_px, magnification, settle_scale, without_empty
from nmaptool.depth.slopes import continue_to_jumps, jump_sizes, normals_of
from nmaptool.depth.steps import JumpRule
from nmaptool.depth.values import GreyValues, grey_values, noise_of, step_of
from nmaptool.errors import InputError, UsageError
from nmaptool.model import Decoding, Frame, NormalMap, RasterImage
from nmaptool.options import DepthOptions
from nmaptool.progress import Progress
from nmaptool.vectors import FLAT, mean_abs_curl
from nmaptool.verbs.relief_inputs import check_mask

# a jump is this high at least: in px, in steps of the codes, and in deviations of the noise
_JUMP_PX, _JUMP_STEPS, _JUMP_NOISE = 1.0, 4.0, 7.0
_MIXED_SHARE = 0.25
# how far the surface may leave the stored heights: half a step, and the noise; lossy files are off by more than that
_NOISE_REACH, _LOSSY_STEPS = 2.5, 1.5
# pixels beside a line of jumps: a motif of one pixel has five, noise often more
_LEAST_LINE, _NOISY_LINE = 5, 12
# noise that a lossy file has near its edges at least, in steps
_LOSSY_NOISE = 1.25
# slopes that are less wrong than this need no fit
_FINE_SLOPE = 0.004


@dataclass
class _Stages:
    """Times by stage, and who wants to know how far the work is."""

    progress: Progress | None
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str, share: float) -> Iterator[None]:
        if self.progress is not None:
            self.progress(name, share)
        start = time.perf_counter()
        yield
        self.seconds[name] = round(time.perf_counter() - start, 4)


def depth_to_normals(
    image: RasterImage,
    options: DepthOptions | None = None,
    *,
    mask: Float32 | None = None,
    progress: Progress | None = None,
) -> DepthNormals:
    """Turn a depth or height picture into a normal map.

    Jumps, where one part hides another, are found and never sloped across; stepped or noisy heights are fitted by the
    least bent surface that they allow; clean ones are differenced.

    Parameters
    ----------
    image : RasterImage
        Grey: integer codes or floats, see `nmaptool.read_raster`.
    options : DepthOptions, optional
    mask : (H, W) float32, optional
        Where the surface is, 0 to 1: becomes coverage. What lies outside does not count.
    progress : callable, optional
        Called with a word and the share done.

    Returns
    -------
    DepthNormals

    Raises
    ------
    InputError
        If the picture is coloured or empty, or the mask does not fit or selects nothing.
    UsageError
        If a length in mm needs a pixel's size that is not known, or an option contradicts what the file says.
    """
    options = options or DepthOptions()
    stages = _Stages(progress)
    with stages.stage("reading", 0.0):
        grey, cover = _surface(image, options, mask)
        scale = settle_scale(image, grey, options)
        step, noise = step_of(grey), 0.0
        noise = noise_of(grey.values, grey.known, step)
        heights = grey.values * np.float32(scale.px_per_value)
        lowest = float(heights.min(where=grey.known, initial=np.inf))
    size = abs(scale.px_per_value)
    step_px, noise_px = step * size, noise * size
    rule = _rule(image, options, scale, step_px, noise_px)
    with stages.stage("jumps", 0.2):
        if rule is not None:
            parts = part_surfaces(heights, grey.known, rule)
        else:
            parts = Surfaces(heights, *join_all(grey.known))
        heights, across, down, mixed = parts.heights, parts.across, parts.down, parts.mixed
        jumps = jump_sizes(heights, grey.known, across, down)
    tolerance = _tolerance(image, options, scale, step_px, noise_px)
    with stages.stage("surface", 0.4):
        slack = np.full(heights.shape, tolerance, np.float32)
        if noise_px or image.lossy:
            widen_tolerance(slack, jumps)
        ground, word = _ground(options, grey, heights, lowest, slack if noise_px or image.lossy else None)
        if tolerance:
            heights = fit_surface(heights, slack, across, down)
        del slack
    with stages.stage("normals", 0.8):
        normals = normals_of(heights, across, down, fine=not tolerance, factor=magnification(heights, scale))
        continue_to_jumps(normals, across, down)
    top = heights.max(where=grey.known, initial=-np.inf)
    height_range = float(top - heights.min(where=grey.known, initial=np.inf))
    del heights, across, down
    normal_map = _map(image, scale, grey, normals, cover, ground, word)
    beside = np.count_nonzero(jumps)
    share = beside / max(np.count_nonzero(grey.known), 1)
    with stages.stage("curl", 0.9):
        turn = mean_abs_curl(normal_map.normals, normal_map.foreground)
    report = DepthReport(
        options=options,
        kind=scale.kind,
        bits=grey.bits,
        scale_px=scale.scale_px,
        scale_from=scale.scale_from,
        range_px=height_range,
        pitch_mm=scale.pitch_mm,
        inverted=scale.inverted,
        inverted_from=scale.inverted_from,
        fov=scale.fov,
        fov_from=scale.fov_from,
        step_px=step_px,
        noise_px=noise_px,
        tolerance_px=tolerance,
        jump_px=rule.least if rule is not None else None,
        jumps=int(beside),
        jump_share=float(share),
        mixed_pixels=mixed,
        background=word,
        background_share=float(1 - normal_map.foreground.mean()),
        curl=turn,
        seconds=stages.seconds,
        warnings=normal_map.decoding.warnings,
    )
    return DepthNormals(normal_map, jumps, report)


def _surface(image: RasterImage, options: DepthOptions, mask: Any) -> tuple[GreyValues, Float32 | None]:
    """The grey values where there is a surface, and its coverage (None: all of it is covered where known)."""
    if not isinstance(image, RasterImage):
        raise UsageError(f"the picture must be a RasterImage, found {type(image).__name__}; read one with read_raster")
    given = check_mask(mask)
    if given is not None and given.shape != image.frame.shape:
        size = " x ".join(str(n) for n in reversed(given.shape))
        raise InputError(f"{image.name} is {image.frame} pixels but the mask is {size}; make them the same size")
    grey = without_empty(image, grey_values(image), options)
    cover = image.alpha
    if given is not None:
        known = grey.known & (given > 0)
        if not (known & (given >= 0.5)).any():
            raise InputError("the mask selects nothing of the picture: paint the motif white (0.5 or more) on black")
        cover = given if cover is None else cover * given
        grey = GreyValues(grey.values, known, grey.top, grey.is_float, grey.bits, grey.noisy_grey, grey.nothing)
    return grey, cover


def _rule(
    image: RasterImage, options: DepthOptions, scale: Scale, step_px: float, noise_px: float
) -> JumpRule | None:
    if options.jump == "none":
        return None
    if options.jump != "auto":
        least = in_px(options.jump, image.frame.cols, scale.pitch_mm, "jump", image.name)
        return JumpRule(least, _MIXED_SHARE * least, by_hand=True)
    unsure = max((_LOSSY_NOISE if image.lossy else 0.0) * step_px, noise_px)
    least = max(_JUMP_PX, _JUMP_STEPS * step_px, _JUMP_NOISE * unsure)
    mixed = max(_MIXED_SHARE * _JUMP_PX, _JUMP_STEPS / 2 * step_px, _JUMP_NOISE / 2 * unsure)
    return JumpRule(least, mixed, 2 * unsure, _NOISY_LINE if unsure else _LEAST_LINE)


def _tolerance(
    image: RasterImage, options: DepthOptions, scale: Scale, step_px: float, noise_px: float
) -> float:
    if options.smooth == "none":
        return 0.0
    if options.smooth != "auto":
        return in_px(options.smooth, image.frame.cols, scale.pitch_mm, "smooth", image.name)
    if max(step_px, noise_px) < _FINE_SLOPE:
        return 0.0
    return step_px * (_LOSSY_STEPS if image.lossy else 0.5) + _NOISE_REACH * noise_px


def _ground(
    options: DepthOptions, grey: GreyValues, heights: Float32, lowest: float, slack: Float32 | None
) -> tuple[Mask | None, str]:
    """The flat background, and what kind of backgrounds there are."""
    words = ["empty"] if grey.nothing else []
    if options.background != "none":
        ground = find_ground(heights, lowest, grey.known, slack)
        if ground.any():
            words.append("cut" if options.background == "cut" else "flat")
            return ground, ", ".join(words)
    return None, ", ".join(words) or "none"


def _map(
    image: RasterImage,
    scale: Scale,
    grey: GreyValues,
    normals: Float32,
    cover: Float32 | None,
    ground: Mask | None,
    word: str,
) -> NormalMap:
    """The map, its background flat; a background that is cut has no coverage."""
    coverage = grey.known.astype(np.float32)
    if cover is not None:
        coverage *= cover
    foreground = coverage >= 0.5
    if ground is not None:
        foreground &= ~ground
        normals[ground] = FLAT
        if word.endswith("cut"):
            coverage[ground] = 0
    normals[~grey.known] = FLAT
    warnings: tuple[str, ...] = ()
    if grey.noisy_grey:
        warnings += ("its colours differ a little; their mean was taken for grey",)
    rows, cols = image.frame.shape
    kind = "flat" if word.endswith("flat") else "none" if word == "none" else "alpha"
    decoding = Decoding(
        encoding="signed", zero_code="0", background=kind, background_from="given" if kind == "none" else "found",
        warnings=warnings,
    )
    return NormalMap(normals, coverage, Frame(rows, cols, scale.pitch_mm), foreground, image.name, decoding)

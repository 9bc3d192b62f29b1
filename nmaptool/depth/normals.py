"""Convert a depth or height picture to a normal map."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.progress import Progress, Stages
from nmaptool.depth.exactness import descent_steps, jump_rule, tolerance_of
from nmaptool.depth.fit import fit_surface
from nmaptool.depth.ground import find_ground
from nmaptool.depth.jumps import Surfaces, join_all, part_surfaces
from nmaptool.depth.outlines import continue_to_jumps
from nmaptool.depth.rim import slack_of
from nmaptool.depth.scale import magnification
from nmaptool.depth.slopes import jump_sizes, mean_curl, normals_of
from nmaptool.depth.source import DepthSource, read_source
from nmaptool.depth.values import extremes
from nmaptool.depth.warnings import warnings_of
from nmaptool.options import DepthOptions
from nmaptool.types.depth import DepthReport, DepthResult
from nmaptool.types.inputs import MaskLike, RasterLike, as_raster
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.plain_arrays import as_mask


def depth_to_normals(
    image: RasterLike,
    options: DepthOptions | None = None,
    *,
    mask: MaskLike | None = None,
    progress: Progress | None = None,
) -> DepthResult:
    """Turn a depth or height picture into a normal map.

    Jumps, where one part hides another, are detected, and no slope is computed across them. Stepped or noisy heights
    are replaced by the smoothest surface within their tolerance; clean heights are differenced.

    Parameters
    ----------
    image : RasterImage, or (H, W) uint8, uint16 or float
        Grey: integer codes or floats; see `nmaptool.read_raster`. NaN and infinite values mean that there is no depth.
    options : DepthOptions, optional
        Which end is near, the scale of the values, jumps, smoothing, background.
    mask : (H, W) bool or float in [0, 1], optional
        Where the surface is; it becomes the coverage. Pixels outside are ignored.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    DepthResult
        The normal map, the height of jumps in px, and the report.

    Raises
    ------
    InputError
        If the picture is coloured or empty, or the mask has another size or selects nothing.
    UsageError
        If a length is in mm and the pitch is unknown, an option contradicts the file, or the picture is neither a
        RasterImage nor an array.

    Examples
    --------
    Heights that rise by half a pixel per pixel to the right, given in px:

    >>> heights = 0.5 * np.arange(16) + np.zeros((16, 1))
    >>> options = nm.DepthOptions(depth_scale=nm.length("7.5px"), background="none")
    >>> normals = nm.depth_to_normals(heights, options).normal_map.normals
    >>> (-normals[8, 8, :2] / normals[8, 8, 2]).round(3).tolist()
    [0.5, -0.0]
    """
    options = options or DepthOptions()
    stages = Stages(progress)
    with stages.stage("reading", 0.0):
        source = read_source(as_raster(image), options, None if mask is None else as_mask(mask))
        heights, known, scale = source.heights, source.grey.known, source.scale
        rule = jump_rule(options, source)
    with stages.stage("jumps", 0.2):
        parts = part_surfaces(heights, known, rule) if rule is not None else Surfaces(heights, *join_all(known))
        heights, across, down = parts.heights, parts.across, parts.down
        jumps = jump_sizes(heights, known, across, down)
    with stages.stage("surface", 0.4):
        tolerance = tolerance_of(options, source)
        mixed = rule is not None and parts.mixed > 0
        slack = slack_of(heights, jumps, tolerance, source.unsure, rule.least_mixed if rule and mixed else None)
        ground, word = _ground(options, source, heights, slack)
        if tolerance:
            heights = fit_surface(heights, slack, across, down, descent_steps(tolerance, source.step_px, heights.size))
        del slack
    with stages.stage("normals", 0.8):
        flat = ground if known.all() else ~known if ground is None else ground | ~known
        factor = magnification(heights, scale)
        normals = normals_of(heights, across, down, flat, fine=not tolerance, factor=factor)
        continue_to_jumps(normals, across, down, flat, clean=not tolerance)
        lowest, highest = extremes(heights, known)
        del heights, across, down, factor, flat
        normal_map = _map(source, normals, ground, word)
    beside = int(np.count_nonzero(jumps))
    with stages.stage("curl", 0.9):
        turn = mean_curl(normal_map.normals, normal_map.foreground)
    report = DepthReport(
        options=options,
        **source.facts(),
        empty_pixels=source.grey.nothing,
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
        warnings=(*normal_map.decoding.warnings, *warnings_of(source, options, highest - lowest)),
    )
    return DepthResult(normal_map, jumps, report)


def _ground(options: DepthOptions, source: DepthSource, heights: Float32, slack: Float32) -> tuple[Mask | None, str]:
    """Return the flat background, if there is one, and the kinds of background found."""
    kinds = ["empty"] if source.grey.nothing else []
    if options.background != "none":
        ground = find_ground(heights, source.lowest, source.grey.known, slack if source.unsure else None)
        if ground.any():
            kinds.append("flat" if options.background == "flat" else "cut")
            return ground, ", ".join(kinds)
    return None, ", ".join(kinds) or "none"


def _map(source: DepthSource, normals: Float32, ground: Mask | None, word: str) -> NormalMap:
    """Return the normal map; a flat background is kept as background, a cut one has no coverage."""
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
        warnings=("the colour channels differ slightly; their mean is used as grey",) if source.grey.noisy_grey else (),
    )
    frame = Frame(*image.frame.shape, source.scale.pitch_mm)
    return NormalMap(normals, coverage, frame, foreground, image.name, decoding, word.endswith("flat"))

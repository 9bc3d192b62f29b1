"""Decisions about a large depth picture, made once for the whole from a sample: meaning, empty values, scale, jumps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import Length
from nmaptool.depth.empty import depths_of
from nmaptool.depth.exactness import jump_rule, tolerance_of
from nmaptool.depth.jumps import mixed_ends_of
from nmaptool.depth.meaning import Meaning, kind_of, meaning_of
from nmaptool.depth.mixed import is_smoothed
from nmaptool.depth.scale import Scale, in_px
from nmaptool.depth.source import DepthSource, largest_hole, settled_source
from nmaptool.depth.steps import JumpRule
from nmaptool.depth.values import GreyValues, grey_values
from nmaptool.options import DepthOptions
from nmaptool.types.picture import Frame, RasterImage

# px around a window: lines of jumps, links and outlines; and with a fitted surface, its forms
JUMP_MARGIN_PX, FIT_MARGIN_PX = 64, 192
# the longest hole that is filled by itself, in px: windows reach so far
LONGEST_HOLE_PX = 64
_MOST_MARKS = 16


@dataclass(frozen=True, eq=False, repr=False)
class SampledImage(RasterImage):
    """Windows of a picture, joined, with the frame of the whole picture."""

    whole: Frame = field(default_factory=lambda: Frame(1, 1))

    @property
    def frame(self) -> Frame:
        """Size of the whole picture, and its pitch."""
        return self.whole


@dataclass(frozen=True)
class EmptyRule:
    """Which values mean "no depth", settled for the whole picture.

    Attributes
    ----------
    named : tuple of float
        Stored values, given or stated by the file.
    marks : tuple of float
        Values that were found in the sample.
    least, most : float or None
        Values up to ``least`` and from ``most`` on.
    narrowed_by : int
        As in `nmaptool.maps.settled.SettledReading`.
    """

    named: tuple[float, ...] = ()
    marks: tuple[float, ...] = ()
    least: float | None = None
    most: float | None = None
    narrowed_by: int = 0


@dataclass(frozen=True)
class SettledDepth:
    """How the windows of a picture become normals, with all decisions made.

    Attributes
    ----------
    rule : EmptyRule
    scale : Scale
    jumps : JumpRule or None
    has_mixed, smoothed : bool
        Whether there are mixed pixels, and whether outlines are smoothed.
    tolerance, unsure, lowest, step_px, least_jump : float
        In px.
    fill_px : float
        Largest width of a hole to fill; 0 fills none.
    fills_all : bool
        Whether every hole in the coverage is filled, not only dropouts.
    longest : int
        Most rows or columns of such a hole.
    pixels : int
        Of the whole picture.
    """

    rule: EmptyRule
    scale: Scale
    jumps: JumpRule | None
    has_mixed: bool
    smoothed: bool
    tolerance: float
    unsure: float
    lowest: float
    step_px: float
    least_jump: float
    fill_px: float
    fills_all: bool
    longest: int
    pixels: int

    @property
    def margin(self) -> int:
        """Pixels around a window that its normals depend on; a multiple of 64, on which coarse grids begin."""
        needed = (FIT_MARGIN_PX if self.tolerance else JUMP_MARGIN_PX) + (self.longest if self.fill_px else 0)
        return _in_steps(needed)


def settle_empty(
    image: SampledImage, mask: Float32 | None, options: DepthOptions
) -> tuple[EmptyRule, Meaning, GreyValues]:
    """Decide from a sample what its values mean and which are empty.

    Raises
    ------
    UsageError
        If the values are disparities of a known scale, or the picture must be turned.
    InputError
        As `nmaptool.depth_to_normals`.
    """
    if image.orientation != 1:
        raise UsageError(f"{image.name}: its EXIF orientation is {image.orientation}; turn it upright and save it")
    meaning = meaning_of(image, options)
    if meaning.values == "disparity" and meaning.absolute:
        raise UsageError(f"{image.name}: disparities of a large picture are not converted; save it as distances")
    named = meaning.empty if options.empty == "auto" else options.empty_values
    plain = grey_values(image, named)
    grey = depths_of(image, plain, meaning, options)
    gone = np.unique(plain.values[plain.known & ~grey.known])
    least = 0.0 if any(word in grey.empty for word in ("0 or less", "0")) and meaning.absolute else None
    most = None
    if "far beyond the rest" in grey.empty:
        highest = float(grey.values.max(where=grey.known, initial=-np.inf))
        most = float(gone[gone > highest].min())
    rest = [v for v in gone.tolist() if not (least is not None and v <= least) and not (most is not None and v >= most)]
    if len(rest) > _MOST_MARKS:
        raise InputError(
            f"{image.name}: {len(rest)} different values look empty; name those that are with `empty`, or give "
            "`empty='none'`"
        )
    factor = 0
    if grey.bits == 8 and image.pixels.dtype != np.uint8:
        factor = 255 if image.is_float else 257 if not (image.pixels % 257).any() else 256
    if mask is not None:
        grey = replace(grey, known=grey.known & (mask > 0))
    return EmptyRule(named, tuple(rest), least, most, factor), meaning, grey


def settle_depth(
    image: SampledImage,
    grey: GreyValues,
    ends: tuple[float, float],
    rule: EmptyRule,
    meaning: Meaning,
    options: DepthOptions,
    windows: list[tuple[slice, slice]],
) -> tuple[SettledDepth, DepthSource]:
    """Make all other decisions.

    Parameters
    ----------
    image : SampledImage
    grey : GreyValues
        Of the sample.
    ends : (float, float)
        Lowest and highest known value of the whole picture.
    rule : EmptyRule
    meaning : Meaning
    options : DepthOptions
    windows : list of (slice, slice)
        The places of the windows in the sample.

    Returns
    -------
    settled : SettledDepth
    source : DepthSource
        Of the sample, for the report.
    """
    source = settled_source(image, grey, meaning, options, ends)
    jumps, tolerance = jump_rule(options, source), tolerance_of(options, source)
    plain = found = 0
    if jumps is not None:
        for window in windows:
            one, other = mixed_ends_of(source.heights[window], grey.known[window], jumps)
            plain, found = plain + one, found + other
    fill = 0.0
    fills_all = isinstance(options.fill, Length)
    if isinstance(options.fill, Length):
        fill = in_px(options.fill, image.frame.cols, source.scale.pitch_mm, "fill", image.name)
    elif options.fill != "none" and kind_of(image) == "grey":
        fill = min(largest_hole(image.frame), LONGEST_HOLE_PX)
    settled = SettledDepth(
        rule,
        source.scale,
        jumps,
        plain > 0,
        plain > 0 and is_smoothed(plain, found),
        tolerance,
        source.unsure,
        source.lowest,
        source.step_px,
        source.least_jump_px,
        fill,
        fills_all,
        _longest(fill),
        image.frame.rows * image.frame.cols,
    )
    return settled, source


def most_margin_px(options: DepthOptions, frame: Frame) -> int:
    """Return the largest `SettledDepth.margin` that options may lead to, before anything is read."""
    fill = 0.0
    if isinstance(options.fill, Length):
        pitch = frame.pitch_mm if options.width is None else options.width.to_mm(1.0, 1) / frame.cols
        known = pitch is not None or not options.fill.is_absolute
        fill = in_px(options.fill, frame.cols, pitch, "fill", "") if known else 0.0
    return _in_steps(FIT_MARGIN_PX + _longest(fill))


def _longest(fill_px: float) -> int:
    """Most rows or columns of a hole that is filled."""
    return max(LONGEST_HOLE_PX, 2 * int(np.ceil(fill_px)))


def _in_steps(pixels: int) -> int:
    return -(-pixels // 64) * 64

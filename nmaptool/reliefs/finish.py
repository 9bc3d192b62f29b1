"""Scale solved heights to the requested height, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.units import Length
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.fit import factor_for_range
from nmaptool.reliefs.heights import SolveSettings, SolveStatistics, SystemHeights
from nmaptool.reliefs.layout import Layout


@dataclass(frozen=True, eq=False)
class HeightFacts:
    """How the heights of a relief were computed.

    Attributes
    ----------
    range_mm, relief_range_mm : (float, float), float
        Lowest and highest height of the surface; height range of the relief above the background.
    below_share : float
        Share of the motif below a held background.
    delta_px, scale : float
        The delta used; the factor on all heights or on the slopes.
    statistics : SolveStatistics
    """

    range_mm: tuple[float, float]
    relief_range_mm: float
    below_share: float
    delta_px: float
    scale: float
    statistics: SolveStatistics


@dataclass(frozen=True, eq=False)
class FinishedHeights:
    """Heights of a relief and how they were computed.

    Attributes
    ----------
    z_mm : (H+1, W+1) float64
    facts : HeightFacts
    """

    z_mm: Float64
    facts: HeightFacts


def finish(
    heights: SystemHeights,
    layout: Layout,
    delta: float,
    options: ReliefOptions,
    pitch_mm: float,
    settings: SolveSettings,
    warm_start: SystemHeights | None,
) -> FinishedHeights:
    """Return heights z = base + h0 + delta h1 with exactly the requested range.

    Parameters
    ----------
    heights : SystemHeights
    layout : Layout
    delta : float
        Delta in px.
    options : ReliefOptions
    pitch_mm : float
    settings : SolveSettings
    warm_start : SystemHeights or None
        Heights of a similar system, from which the solver starts.

    Raises
    ------
    InputError
        If the height cannot be reached.
    ConvergenceError
        If the solver does not reach its tolerance.
    """
    wanted_px = length_px(options.height, layout.motif.shape, pitch_mm)
    if layout.standing is not None:
        above, statistics = heights.at(delta, settings, warm_start)
        edge_px = length_px(options.edge_height, layout.motif.shape, pitch_mm)
        above = layout.standing.heights(above, options, edge_px, wanted_px)
        return _finished(above, layout, pitch_mm, delta, 1.0, statistics)
    if wanted_px is None or options.fit == "scale":
        above, statistics = heights.at(delta, settings, warm_start)
        scale, range_px = 1.0, layout.range_of(above)
        if wanted_px is not None:
            base_px = layout.domain.base_px
            size = max(float(np.abs(above).max()), 0.0 if base_px is None else float(np.abs(base_px).max()))
            scale = factor_for_height(range_px, size, wanted_px, options)
            above *= scale
            range_px = scale * range_px[0], scale * range_px[1]
        return _finished(above, layout, pitch_mm, delta, scale, statistics, range_px)
    first, second, statistics = heights.parts(settings, warm_start)
    slope, inside = 1.0, layout.inside
    if options.fit == "slope":
        slope = factor_for_range(delta * inside(second), inside(first), wanted_px, "the slopes", pitch_mm)
    else:
        side = -1.0 if delta < 0 else 1.0  # keeps the sign: an engraving stays an engraving
        delta = side * factor_for_range(inside(first), side * inside(second), wanted_px, "delta", pitch_mm)
    above = slope * first
    above += delta * second
    return _finished(above, layout, pitch_mm, delta, slope, statistics)


def length_px(length: Length | None, shape: tuple[int, ...], pitch_mm: float) -> float | None:
    """A length in px of a picture of this shape; None if there is none."""
    return None if length is None else length.to_mm(pitch_mm, max(shape)) / pitch_mm


def factor_for_height(range_px: tuple[float, float], size_px: float, wanted_px: float, options: ReliefOptions) -> float:
    """Return the factor on all heights that gives them a range.

    Parameters
    ----------
    range_px : (float, float)
        Their lowest and highest value.
    size_px : float
        The largest absolute value, with that of the background: ranges of its rounding errors are flat.
    wanted_px : float
    options : ReliefOptions

    Raises
    ------
    InputError
        If the heights are flat.
    """
    low, high = range_px
    if high - low <= 1e-12 * max(1.0, size_px):
        raise InputError(f"`height='{options.height}'`: the relief is flat, so no factor gives it a height")
    return wanted_px / (high - low)


def _finished(
    above: Float64,
    layout: Layout,
    pitch_mm: float,
    delta: float,
    scale: float,
    statistics: SolveStatistics,
    range_px: tuple[float, float] | None = None,
) -> FinishedHeights:
    """Return the heights in mm; ``above``, in px above the background, is overwritten.

    ``range_px`` is its lowest and highest value on the surface, if they are known.
    """
    low, high = layout.range_of(above) if range_px is None else range_px
    relief_range_mm = (high - low) * pitch_mm
    below = layout.share_below(above) if layout.holds else 0.0
    if layout.domain.base_px is not None:
        above += layout.domain.base_px
        low, high = layout.range_of(above)
    above *= pitch_mm
    range_mm = low * pitch_mm, high * pitch_mm
    return FinishedHeights(above, HeightFacts(range_mm, relief_range_mm, below, delta, scale, statistics))

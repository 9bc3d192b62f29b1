"""One combination of the options of a relief that need a solve, and the layout of its maps."""

from __future__ import annotations

import dataclasses

import numpy as np

from nmaptool.core.grid import dilated
from nmaptool.options import ReliefOptions
from nmaptool.reliefs import inputs as given
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.heights import SystemHeights
from nmaptool.reliefs.layout import Layout
from nmaptool.reliefs.motif import height_term_mask, motif_of, rounded_motif, walled
from nmaptool.reliefs.report import SolverFacts
from nmaptool.reliefs.rounding import rounded
from nmaptool.reliefs.standing import Standing, bridged, flat_share, stands
from nmaptool.reliefs.targets import CappedSlopes
from nmaptool.types.normal_map import NormalMap

CappedPair = tuple[CappedSlopes, CappedSlopes | None]


@dataclasses.dataclass(frozen=True, eq=False)
class Case:
    """One combination of the options that need a solve, and its results.

    ``ground``, ``system`` and ``shape`` hold the values that the layout, the solver and the heights depend on.
    """

    ground: tuple[object, ...]
    system: tuple[object, ...]
    shape: tuple[object, ...]
    layout: Layout
    slope_cap: float
    capped: CappedPair | None
    heights: SystemHeights
    facts: SolverFacts
    pulled: bool
    steep_share: float


def ground_key(maps: given.ReliefMaps, options: ReliefOptions, pitch_mm: float) -> tuple[object, ...]:
    """Return what the layout depends on, except the tolerance to which a background's normal map is integrated."""
    if options.background != "surface":
        return (options.background, options.edge, given.radius_px_of(options, pitch_mm))
    return (options.background, options.slope_cap if isinstance(maps.surface, NormalMap) else pitch_mm)


def holds(case: Case, maps: given.ReliefMaps, options: ReliefOptions) -> bool:
    """Whether the background of a case was integrated to the requested tolerance."""
    integrated = options.background == "surface" and isinstance(maps.surface, NormalMap)
    return not integrated or case.layout.tolerance <= options.tolerance


def layout_of(maps: given.ReliefMaps, options: ReliefOptions, pitch_mm: float) -> Layout:
    """Return the layout of the maps for these options."""
    original, mask = maps.original, maps.mask
    motif = motif_of(original, mask, fading=options.background in ("plane", "surface"))
    base_px, ground = given.base_of(maps.surface, pitch_mm, options)
    coverage = maps.coverage
    radius_px = given.radius_px_of(options, pitch_mm)
    if radius_px:
        coverage = rounded(np.where(motif, coverage, np.minimum(coverage, 0.49)), radius_px)
        motif = rounded_motif(coverage, options)
    standing = None
    if stands(options, original.normals, motif, maps.walls is not None):
        raised = bridged(walled(motif, maps.walls), coverage)
        # a pixel of plate lies between what stands and what does not
        motif = raised if maps.walls is None else raised | (motif & ~dilated(raised, 1))
        standing = Standing(raised)
    domain = build_domain(
        options.background,
        motif,
        original.coverage >= 0.5,
        coverage,
        base_px,
        height_term_mask(original, motif, mask),
        ground,
        None if standing is None else standing.motif,
    )
    flat = flat_share(original.normals, motif)
    return Layout(domain, motif, options.tolerance, coverage, standing, flat)

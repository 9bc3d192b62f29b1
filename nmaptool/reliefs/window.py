"""The linear system in one window of maps that are larger than memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.domain import Domain, build_domain
from nmaptool.reliefs.inputs import ReliefMaps, radius_px_of
from nmaptool.reliefs.motif import motif_in
from nmaptool.reliefs.rounding import MARGIN_PX, rounded
from nmaptool.reliefs.standing import flat_share
from nmaptool.reliefs.targets import Weights, build_targets, capped_slopes

# repair of rims and fading masks look at this many pixels around
_LEAST_MARGIN_PX = 4


def margin_px(options: ReliefOptions, pitch_mm: float) -> int:
    """Pixels around a window that its system depends on.

    Rounded corners are found in four steps of one radius, each of which looks at up to two radii.
    """
    radius_px = radius_px_of(options, pitch_mm)
    return _LEAST_MARGIN_PX if not radius_px else int(np.ceil(8 * radius_px)) + 4 * MARGIN_PX + _LEAST_MARGIN_PX


@dataclass(frozen=True, eq=False)
class WindowSystem:
    """The system of a window, and what it contributes to the report.

    Attributes
    ----------
    weight : (h, w) float32
    beta : (h+1, w+1) float32
    held : (h+1, w+1) bool
    load : (h+1, w+1) float64
        For delta 0.
    pull : (h+1, w+1) float32
        What each px of delta adds.
    surface : (h+1, w+1) bool
        Vertices of the finished surface.
    motif : (h, w) bool
    coverage : (h, w) float32
    foreground : (h, w) bool
        Where the height term acts.
    selected : bool
        Whether the mask selects anything, motif or background.
    steep, acting, flat : int
        Acting faces whose slope was capped, acting faces, faces of the motif that are flat; all of the inner part.
    base_px : (h+1, w+1) float64 or None
    """

    weight: Float32
    beta: Float32
    held: Mask
    load: Float64
    pull: Float32
    surface: Mask
    motif: Mask
    coverage: Float32
    foreground: Mask
    selected: bool
    steep: int
    acting: int
    flat: int
    base_px: Float64 | None


def window_system(
    maps: ReliefMaps,
    options: ReliefOptions,
    weights: Weights,
    pitch_mm: float,
    inner: tuple[slice, slice],
    base_px: Float64 | None = None,
) -> WindowSystem:
    """Return the system of a window; it is that of the whole picture except near the sides of the window.

    Parameters
    ----------
    maps : ReliefMaps
        Windows of all maps.
    options : ReliefOptions
    weights : Weights
        For the whole picture, with the windows of its maps.
    pitch_mm : float
    inner : pair of slices
        The pixels to count.
    base_px : (h+1, w+1) float64, optional
        Height of the curved background.
    """
    original = maps.original
    motif, chosen = motif_in(original, maps.mask, fading=options.background in ("plane", "surface"))
    coverage = maps.coverage
    radius_px = radius_px_of(options, pitch_mm)
    if radius_px:
        coverage = rounded(np.where(motif, coverage, np.minimum(coverage, np.float32(0.49))), radius_px)
        motif = coverage >= 0.5
    domain: Domain = build_domain(options.background, motif, original.coverage >= 0.5, coverage, base_px)
    first = capped_slopes(original.normals, options.slope_cap)
    second = None if maps.detail is None else capped_slopes(maps.detail.normals, options.slope_cap)
    energy = options.energy if maps.detail is not None else "eq6"
    targets = build_targets(original, maps.detail, domain, weights, options.slope_cap, energy, (first, second))
    acting, here = domain.acting[inner], motif[inner]
    return WindowSystem(
        targets.weight,
        targets.beta,
        domain.held,
        targets.shape_load(base_px),
        targets.pull,
        touching_vertices(domain.surface),
        motif,
        coverage,
        domain.foreground,
        bool(chosen[inner].any()),
        int(np.count_nonzero(first.steep[inner] & acting)),
        int(np.count_nonzero(acting)),
        round(flat_share(original.normals[inner], here) * np.count_nonzero(here)) if here.any() else 0,
        base_px,
    )

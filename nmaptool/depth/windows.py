"""Heights and normals of windows of a large depth picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.depth.exactness import descent_steps
from nmaptool.depth.fill import fill_holes
from nmaptool.depth.fit import fit_surface
from nmaptool.depth.ground import is_low
from nmaptool.depth.jumps import Surfaces, join_all, part_surfaces
from nmaptool.depth.outlines import continue_to_jumps
from nmaptool.depth.rim import slack_of
from nmaptool.depth.scale import magnification
from nmaptool.depth.settled import EmptyRule, SettledDepth
from nmaptool.depth.slopes import jump_sizes, normals_of
from nmaptool.depth.values import NOTHING, GreyValues, grey_values
from nmaptool.maps.settled import SettledReading, narrowed_as_settled
from nmaptool.types.picture import RasterImage


@dataclass(frozen=True, eq=False)
class WindowSurface:
    """The surface in a window, before it is fitted.

    Attributes
    ----------
    parts : Surfaces
    known : (h, w) bool
    cover : (h, w) float32 or None
    jumps, slack : (h, w) float32
    low : (h, w) bool
        Pixels at the lowest height.
    filled, moved : (h, w) bool
        Pixels of holes, and mixed pixels that were moved to one side.
    """

    parts: Surfaces
    known: Mask
    cover: Float32 | None
    jumps: Float32
    slack: Float32
    low: Mask
    filled: Mask
    moved: Mask


def window_values(
    image: RasterImage, rule: EmptyRule, mask: Float32 | None
) -> tuple[GreyValues, Float32 | None, dict[str, int]]:
    """Return the values of a window, its coverage (None: 1 where values are known) and counts of empty pixels.

    Raises
    ------
    InputError
        If it is coloured, or holds finer values than the sample.
    """
    stored = image.pixels[..., 0]
    grey = grey_values(narrowed_as_settled(image, SettledReading(narrowed_by=rule.narrowed_by)), part=True)
    values, known = grey.values, grey.known.copy()
    nothing = np.zeros_like(known) if grey.dropouts is None else grey.dropouts.copy()
    counts = dict(grey.empty)

    def remove(found: Mask, word: str, dropout: bool) -> None:
        nonlocal nothing
        found = found & known
        count = int(np.count_nonzero(found))
        if count:
            counts[word] = counts.get(word, 0) + count
            known[found] = False
            if dropout:
                nothing |= found

    for value in rule.named:
        remove(stored.astype(np.float64) == value, f"{value:g}", value not in NOTHING)
    for value in rule.marks:
        remove(values == np.float32(value), f"{value:g}", value not in NOTHING and value < 1e4)
    if rule.least is not None:
        remove(values <= np.float32(rule.least), "0 or less" if grey.is_float else "0", True)
    if rule.most is not None:
        remove(values >= np.float32(rule.most), "far beyond the rest", False)
    cover = image.alpha
    if mask is not None:
        known &= mask > 0
        nothing &= mask > 0
        cover = mask if cover is None else cover * mask
    values = np.where(known, values, np.float32(0))
    return replace(grey, values=values, known=known, dropouts=nothing), cover, counts


def window_surface(image: RasterImage, mask: Float32 | None, settled: SettledDepth) -> WindowSurface:
    """Return the surface in a window: its heights, where it is known, and its jumps."""
    grey, cover, _ = window_values(image, settled.rule, mask)
    heights, known = grey.values * np.float32(settled.scale.px_per_value), grey.known
    filled = np.zeros_like(known)
    dropouts = grey.dropouts
    if settled.fills_all:
        dropouts = ~known if cover is None else ~known & (cover > 0)
    if settled.fill_px and dropouts is not None and dropouts.any():
        found = fill_holes(heights, known, dropouts, settled.fill_px, settled.least_jump, settled.longest)
        if found.pixels is not None:
            heights, filled = found.heights, found.pixels
            known = known | filled
    if settled.jumps is None:
        parts = Surfaces(heights, *join_all(known))
    else:
        parts = part_surfaces(heights, known, settled.jumps, settled.smoothed)
    jumps = jump_sizes(parts.heights, known, parts.across, parts.down)
    mixed = settled.jumps.least_mixed if settled.jumps is not None and settled.has_mixed else None
    slack = slack_of(parts.heights, jumps, settled.tolerance, settled.unsure, mixed)
    low = is_low(parts.heights, settled.lowest, known, slack if settled.unsure else None)
    return WindowSurface(parts, known, cover, jumps, slack, low, filled, parts.heights != heights)


def window_normals(surface: WindowSurface, ground: Mask | None, settled: SettledDepth) -> tuple[Float32, Float32]:
    """Return the normals in a window, and the heights of the surface in px; those in the margin are not final."""
    parts, known = surface.parts, surface.known
    heights, across, down = parts.heights, parts.across, parts.down
    if settled.tolerance:
        steps = descent_steps(settled.tolerance, settled.step_px, settled.pixels)
        heights = fit_surface(heights, surface.slack, across, down, steps, settled.pixels)
    flat = ground if known.all() else ~known if ground is None else ground | ~known
    factor = magnification(heights, settled.scale)
    normals = normals_of(heights, across, down, flat, fine=not settled.tolerance, factor=factor)
    continue_to_jumps(normals, across, down, flat, clean=not settled.tolerance)
    return normals, heights

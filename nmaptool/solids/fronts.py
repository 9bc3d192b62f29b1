"""What a solid is made of before its triangles: the shape of its front, with heights that keep their range."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import UsageError
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.outline import find_splits
from nmaptool.solids.piece import Back
from nmaptool.solids.raised import RaisedFront, raised_front
from nmaptool.solids.shape import Shape, pixel_shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import NO_CUTS, Cuts, has_soft_edges, smooth_foot_line, smooth_shape
from nmaptool.types.height import Height
from nmaptool.types.relief import Relief


def zero_of(relief: Height | Relief, height: Height) -> float:
    """The height that a base is measured from: the plate's, or the lowest of a relief without a plate."""
    if isinstance(relief, Relief) and relief.report.options.background != "plane":
        return height.range_mm[0]
    return 0.0


def shape_of(
    relief: Height | Relief,
    height: Height,
    coverage: Float32 | None,
    options: SolidOptions,
    cuts: Cuts = NO_CUTS,
) -> tuple[Shape, dict[str, Any]]:
    """The shape of a relief's surface, and what was found; nodes on cuts move only along them."""
    mask = height.domain
    motif = relief.foreground if isinstance(relief, Relief) else mask
    has_foot_line = mask.all() and not motif.all()
    edge = motif if has_foot_line else mask
    is_smooth = options.outline == "smooth" or (
        options.outline == "auto" and coverage is not None and has_soft_edges(edge, coverage)
    )
    if not is_smooth or edge.all():
        shape = pixel_shape(mask, find_splits(mask))
        return shape, {"outline": "exact", "outline_deviation_mm": 0.0, "split_corners": len(shape.splits.vertices)}
    coverage = edge.astype(np.float32) if coverage is None else coverage
    if has_foot_line:
        shape, deviation_px = smooth_foot_line(edge, coverage, cuts)
    else:
        rounds = isinstance(relief, Relief) and relief.report.options.outline_round is not None
        shape, deviation_px = smooth_shape(edge, coverage, rounds_border=rounds, cuts=cuts)
    facts = {"outline": "smooth", "outline_deviation_mm": deviation_px * height.pitch_mm}
    return shape, {**facts, "split_corners": len(shape.splits.vertices)}


def in_range(height: Height, shape: Shape) -> Height:
    """Heights whose range is kept by the moved nodes of the outline."""
    if shape.keeps_heights:
        return height
    low, high = Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0)).z_range()
    wanted_low, wanted_high = height.range_mm
    if (low, high) == (wanted_low, wanted_high) or low == high:
        return height
    factor = (wanted_high - wanted_low) / (high - low)
    return dataclasses.replace(height, z_mm=(height.z_mm - low) * factor + wanted_low)


def raised_surface(
    height: Height, coverage: Float32 | None, beside: Mask | None, options: SolidOptions, cuts: Cuts = NO_CUTS
) -> tuple[RaisedFront, dict[str, Any]]:
    """The front of a motif that stands on its plate with walls, and what was found; ``cuts`` as for `shape_of`."""
    assert height.raised is not None
    smooth = options.outline == "smooth"
    if options.outline == "auto" and coverage is not None:
        smooth = has_soft_edges(height.raised, coverage)
    front, deviation_px = raised_front(height, coverage, smooth, beside, cuts=cuts)
    facts = {"outline": "smooth" if smooth else "exact", "outline_deviation_mm": deviation_px * height.pitch_mm}
    return front, facts


def check_raised_back(back: Back | None, options: SolidOptions) -> None:
    """Refuse fewer triangles for a raised motif whose back is not flat."""
    if isinstance(back, Sheet) and (options.max_error is not None or options.triangles is not None):
        name = "max_error" if options.max_error is not None else "triangles"
        kind = "shell" if options.shell is not None else "hollow"
        raise UsageError(f"`{name}` and `{kind}` do not go together with a raised motif; leave one of them out")

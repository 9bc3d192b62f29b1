"""Surfaces to be cut: the fronts of a relief or of a window of it, and the backs that follow them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.fronts import check_raised_back, in_range, raised_surface, shape_of
from nmaptool.solids.outline import find_splits, outline_edges
from nmaptool.solids.piece import back_of
from nmaptool.solids.pieces import pieces_of
from nmaptool.solids.raised import RaisedFront, raised_mask
from nmaptool.solids.shape import Shape, pixel_shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import Cuts
from nmaptool.types.height import Height
from nmaptool.types.parts import PlannedPart
from nmaptool.types.relief import Relief

# moves of nodes are whole multiples of this share of a pixel, so that sums with whole pixels are exact
_STEPS_PER_PX = 1 << 20


@dataclass(frozen=True, eq=False)
class Source:
    """A surface to cut.

    Attributes
    ----------
    front : Sheet or RaisedFront
    back : Sheet or None
        A back that follows the front; None if it is flat, depends on the part, or the surface is open.
    height : Height
        For lengths in px.
    top, left : int
        Upper left corner of the sheets, in pixels of the whole.
    """

    front: Sheet | RaisedFront
    back: Sheet | None
    height: Height
    top: int = 0
    left: int = 0


def sources_of_window(window: Height, top: int, left: int, options: SolidOptions) -> list[Source]:
    """The surface of a window of a relief, whose outline follows the pixels.

    Parameters
    ----------
    window : Height
    top, left : int
        Its upper left corner in the whole.
    options : SolidOptions
        Lengths are in mm.
    """
    if raised_mask(window) is not None:
        front, _ = raised_surface(window, None, None, dataclasses.replace(options, outline="exact"))
        return [_raised_source(front, window, options, top, left)]
    mask = window.domain
    sheet = Sheet(window.z_mm, pixel_shape(mask, find_splits(mask)), Placing(window.pitch_mm, 0, 0))
    return [_source(sheet, window, options, top, left)]


def sources_of_relief(
    relief: Height | Relief, height: Height, options: SolidOptions, plan: Sequence[PlannedPart]
) -> tuple[list[Source], dict[str, Any]]:
    """The surfaces of a relief, one for each piece that a solid has, and what was found.

    Parameters
    ----------
    relief : Height or Relief
    height : Height
        Of the relief.
    options : SolidOptions
        Lengths are in mm.
    plan : sequence of PlannedPart
        Nodes of the outline do not leave the lines between parts.
    """
    tops, lefts = sorted({part.top for part in plan}), sorted({part.left for part in plan})
    cuts = Cuts(tuple(tops[1:]), tuple(lefts[1:]))
    coverage: Float32 | None = relief.coverage if isinstance(relief, Relief) else None
    raised = raised_mask(height)
    if raised is not None:
        beside = relief.foreground & ~raised if isinstance(relief, Relief) else None
        front, facts = raised_surface(height, coverage, beside, options, cuts)
        if facts["outline"] == "smooth":
            front = dataclasses.replace(front, motif=_stepped(front.motif), plate=_stepped(front.plate))
        return [_raised_source(front, height, options, 0, 0)], facts
    shape, facts = shape_of(relief, height, coverage, options, cuts)
    shape = _in_steps(shape) if facts["outline"] == "smooth" else shape
    height = in_range(height, shape)
    if not options.is_closed:
        return [_source(Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0)), height, options, 0, 0)], facts
    return [_source(*each) for each in _fronts(height, shape, options)], facts


def _fronts(
    height: Height, shape: Shape, options: SolidOptions
) -> Iterator[tuple[Sheet, Height, SolidOptions, int, int]]:
    """The pieces of a shape, as the arguments of `_source`."""
    for piece, top, left in pieces_of(shape):
        rows, cols = piece.mask.shape
        z_mm = height.z_mm[top : top + rows + 1, left : left + cols + 1]
        yield Sheet(z_mm, piece, Placing(height.pitch_mm, 0, 0)), height, options, top, left


def _source(front: Sheet, height: Height, options: SolidOptions, top: int, left: int) -> Source:
    """A sheet with its shell."""
    back = None
    if options.shell is not None:
        found = back_of(front, outline_edges(front.shape.mask, front.shape.splits), height, options, 0.0)
        assert isinstance(found, Sheet)
        back = found
    return Source(front, back, height, top, left)


def _raised_source(front: RaisedFront, height: Height, options: SolidOptions, top: int, left: int) -> Source:
    back = None
    if options.shell is not None:
        found = back_of(front.whole, front.border(), height, options, 0.0)
        assert isinstance(found, Sheet)
        check_raised_back(found, options)
        back = found
    return Source(front, back, height, top, left)


def _stepped(sheet: Sheet) -> Sheet:
    return dataclasses.replace(sheet, shape=_in_steps(sheet.shape))


def _in_steps(shape: Shape) -> Shape:
    return dataclasses.replace(shape, by_px=np.round(shape.by_px * _STEPS_PER_PX) / _STEPS_PER_PX)

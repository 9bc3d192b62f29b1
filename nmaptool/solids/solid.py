"""A relief to triangles: an open surface, or closed bodies with walls and a back."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.units import Length
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.bodies import closed_solid
from nmaptool.solids.exact.build import plate_solid
from nmaptool.solids.fronts import check_raised_back, in_range, raised_surface, shape_of, zero_of
from nmaptool.solids.outline import outline_edges
from nmaptool.solids.piece import Piece, back_of, bounds_of, pocket_mm3
from nmaptool.solids.pieces import pieces_of
from nmaptool.solids.raised import RaisedPiece, raised_mask
from nmaptool.solids.shape import Shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.thinning import thinned_front, thinned_surfaces
from nmaptool.types.height import Height
from nmaptool.types.inputs import as_height
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Body, Solid


def solid(relief: Height | Relief, options: SolidOptions | None = None) -> Solid:
    """Triangulate a relief: an open surface, or closed bodies with walls and a back.

    Every body is a manifold, whatever the mask: pixels that touch only at a corner do not share that corner.

    Parameters
    ----------
    relief : Height or Relief
        A relief has the coverage of its outline, a height field only its pixels. A height field with an ``outline``
        becomes a plate with exactly this outline.
    options : SolidOptions, optional
        Default: the open surface with two triangles for each pixel.

    Returns
    -------
    Solid
        In mm: +x right, +y up, +z to the viewer, the lower left corner of the picture at (0, 0). Heights stay as they
        are: the plate lies at z = 0 and the back below it.

    Raises
    ------
    InputError
        If the base is thinner than the relief is deep, or the relief falls apart and ``one_piece`` is given.
    UsageError
        If it is something else, such as an array, which does not know the size of a pixel.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.solid(height, nm.SolidOptions(base=nm.length("2mm")))
    <Solid 1.5 x 1 x 2 mm, 1 closed body, 42 faces>
    """
    options = options or SolidOptions()
    height = as_height(relief)
    if height.outline is not None:
        return plate_solid(relief, height, _of_plate(options, relief))
    coverage = relief.coverage if isinstance(relief, Relief) else None
    raised = raised_mask(height)
    if raised is not None:
        beside = relief.foreground & ~raised if isinstance(relief, Relief) else None
        return _raised(height, coverage, beside, options)
    shape, facts = shape_of(relief, height, coverage, options)
    height = in_range(height, shape)
    if not options.is_closed:
        return _surface(height, shape, options, facts)
    zero_mm = zero_of(relief, height)
    pieces = [_piece_of(height, *placed, options, zero_mm) for placed in pieces_of(shape)]
    _check_count(pieces, options)
    if options.hollow is not None:
        facts["hollowed_mm3"] = sum(pocket_mm3(piece.back) for piece in pieces)
    thinned = thinned_surfaces([(piece.front, piece.edges, piece.back) for piece in pieces], height, options, facts)
    pieces = [Piece(front, edges, back) for front, edges, back in thinned if back is not None]
    return closed_solid(pieces, facts)


def _of_plate(options: SolidOptions, relief: Height | Relief) -> SolidOptions:
    """Options whose lengths in % refer to the longer side of a plate."""
    if not isinstance(relief, Relief) or relief.plate is None:
        return options
    longer_mm = max(relief.plate.width_mm, relief.plate.height_mm)
    lengths = {name: getattr(options, name) for name in ("base", "shell", "hollow", "max_error")}
    shares: dict[str, Any] = {
        name: Length(each.value / 100 * longer_mm, "mm")
        for name, each in lengths.items()
        if each is not None and each.unit == "%"
    }
    return dataclasses.replace(options, **shares)


def _piece_of(height: Height, shape: Shape, top: int, left: int, options: SolidOptions, zero_mm: float) -> Piece:
    """The closed body of a piece of the shape."""
    rows, cols = shape.mask.shape
    z_mm = height.z_mm[top : top + rows + 1, left : left + cols + 1]
    front = Sheet(z_mm, shape, Placing(height.pitch_mm, left, height.frame.rows - top - rows))
    edges = outline_edges(shape.mask, shape.splits)
    return Piece(front, edges, back_of(front, edges, height, options, zero_mm))


def _check_count(pieces: Sequence[Piece], options: SolidOptions) -> None:
    """Refuse several pieces where one is demanded."""
    if len(pieces) > 1 and options.one_piece:
        sizes = sorted(int(np.count_nonzero(piece.front.shape.mask)) for piece in pieces)
        raise InputError(
            f"`one_piece`: the relief has {len(pieces)} separate pieces, the largest of {sizes[-1]} px and the "
            f"smallest of {sizes[0]} px; connect them in the mask, or leave out `one_piece`"
        )


def _raised(height: Height, coverage: Float32 | None, beside: Mask | None, options: SolidOptions) -> Solid:
    """The solid or surface of a motif that stands on its plate with walls."""
    front, facts = raised_surface(height, coverage, beside, options)
    if not options.is_closed:
        front = thinned_front(front, height, options, facts, ())
        body = Body("relief", front.parts, front.face_count, front.node_count)
        return Solid((body,), False, front.bounds_mm, facts=facts)
    back = back_of(front.whole, front.border(), height, options, 0.0)
    check_raised_back(back, options)
    if options.hollow is not None:
        facts["hollowed_mm3"] = pocket_mm3(back)
    front = thinned_front(front, height, options, facts, (back,))
    return closed_solid([RaisedPiece.of(front, back)], facts)


def _surface(height: Height, shape: Shape, options: SolidOptions, facts: dict[str, Any]) -> Solid:
    """The open surface, as one body."""
    sheet = Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0))
    ((sheet, edges, _),) = thinned_surfaces(
        [(sheet, outline_edges(shape.mask, shape.splits), None)], height, options, facts
    )
    body = Body("relief", sheet.parts, sheet.face_count, shape.node_count)
    return Solid((body,), False, bounds_of(sheet, edges), facts=facts)

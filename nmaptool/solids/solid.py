"""A relief to triangles: an open surface, or closed bodies with walls and a back."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.grid import touching_vertices
from nmaptool.core.units import Length
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.exact.build import plate_solid
from nmaptool.solids.flat_back import FlatBack, rectangle_corners
from nmaptool.solids.outline import find_splits, outline_edges
from nmaptool.solids.piece import Back, Piece, back_of, bounds_of, in_mm, pocket_mm3
from nmaptool.solids.pieces import pieces_of
from nmaptool.solids.raised import RaisedFront, RaisedPiece, raised_front, raised_mask
from nmaptool.solids.shape import Shape, pixel_shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import has_soft_edges, smooth_foot_line, smooth_shape
from nmaptool.solids.thinned_sheet import Surfaces, Thinning, thin_pieces
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
    shape, facts = _shape_of(relief, height, coverage, options)
    height = _in_range(height, shape)
    if not options.is_closed:
        return _surface(height, shape, options, facts)
    zero_mm = _zero_of(relief, height)
    pieces = [_piece_of(height, *placed, options, zero_mm) for placed in pieces_of(shape)]
    _check_count(pieces, options)
    if options.hollow is not None:
        facts["hollowed_mm3"] = sum(pocket_mm3(piece.back) for piece in pieces)
    thinned = _thinned([(piece.front, piece.edges, piece.back) for piece in pieces], height, options, facts)
    pieces = [Piece(front, edges, back) for front, edges, back in thinned if back is not None]
    return _solid_of(pieces, facts)


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


def _solid_of(pieces: Sequence[Piece | RaisedPiece], facts: dict[str, Any]) -> Solid:
    """A solid of closed bodies."""
    bounds = np.array([piece.bounds_mm for piece in pieces])
    name = "relief" if len(pieces) == 1 else "relief {}"
    return Solid(
        tuple(piece.body(name.format(number)) for number, piece in enumerate(pieces, start=1)),
        True,
        np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)]),
        sum(piece.volume_mm3 for piece in pieces),
        {**facts, "pieces": len(pieces)},
    )


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
    assert height.raised is not None
    smooth = options.outline == "smooth"
    if options.outline == "auto" and coverage is not None:
        smooth = has_soft_edges(height.raised, coverage)
    front, deviation_px = raised_front(height, coverage, smooth, beside)
    facts: dict[str, Any] = {
        "outline": "smooth" if smooth else "exact",
        "outline_deviation_mm": deviation_px * height.pitch_mm,
    }
    if not options.is_closed:
        front = _thinned_front(front, height, options, facts, ())
        body = Body("relief", front.parts, front.face_count, front.node_count)
        return Solid((body,), False, front.bounds_mm, facts=facts)
    back = back_of(front.whole, front.border(), height, options, 0.0)
    if isinstance(back, Sheet) and (options.max_error is not None or options.triangles is not None):
        name = "max_error" if options.max_error is not None else "triangles"
        kind = "shell" if options.shell is not None else "hollow"
        raise UsageError(f"`{name}` and `{kind}` do not go together with a raised motif; leave one of them out")
    if options.hollow is not None:
        facts["hollowed_mm3"] = pocket_mm3(back)
    front = _thinned_front(front, height, options, facts, (back,))
    return _solid_of([RaisedPiece.of(front, back)], facts)


def _zero_of(relief: Height | Relief, height: Height) -> float:
    """The height that a base is measured from: the plate's, or the lowest of a relief without a plate."""
    if isinstance(relief, Relief) and relief.report.options.background != "plane":
        return height.range_mm[0]
    return 0.0


def _shape_of(
    relief: Height | Relief, height: Height, coverage: Float32 | None, options: SolidOptions
) -> tuple[Shape, dict[str, Any]]:
    """The shape of a relief's surface, and what was found."""
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
        shape, deviation_px = smooth_foot_line(edge, coverage)
    else:
        rounds = isinstance(relief, Relief) and relief.report.options.outline_round is not None
        shape, deviation_px = smooth_shape(edge, coverage, rounds_border=rounds)
    facts = {"outline": "smooth", "outline_deviation_mm": deviation_px * height.pitch_mm}
    return shape, {**facts, "split_corners": len(shape.splits.vertices)}


def _in_range(height: Height, shape: Shape) -> Height:
    """Heights whose range is kept by the moved nodes of the outline."""
    if shape.keeps_heights:
        return height
    low, high = Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0)).z_range()
    wanted_low, wanted_high = height.range_mm
    if (low, high) == (wanted_low, wanted_high) or low == high:
        return height
    factor = (wanted_high - wanted_low) / (high - low)
    return dataclasses.replace(height, z_mm=(height.z_mm - low) * factor + wanted_low)


def _surface(height: Height, shape: Shape, options: SolidOptions, facts: dict[str, Any]) -> Solid:
    """The open surface, as one body."""
    sheet = Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0))
    ((sheet, edges, _),) = _thinned([(sheet, outline_edges(shape.mask, shape.splits), None)], height, options, facts)
    body = Body("relief", sheet.parts, sheet.face_count, shape.node_count)
    return Solid((body,), False, bounds_of(sheet, edges), facts=facts)


def _thinned(
    surfaces: Sequence[Surfaces], height: Height, options: SolidOptions, facts: dict[str, Any]
) -> Sequence[Surfaces]:
    """The pieces with as many triangles as the options ask for."""
    if options.max_error is None and options.triangles is None:
        return surfaces
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    pieces = [Thinning(*each) for each in surfaces]
    thinned, facts["max_error_mm"] = thin_pieces(pieces, error_mm, options.triangle_count, options.triangles)
    return thinned


def _thinned_front(
    front: RaisedFront, height: Height, options: SolidOptions, facts: dict[str, Any], backs: Sequence[Back]
) -> RaisedFront:
    """A raised front with as many triangles as the options ask for."""
    if options.max_error is None and options.triangles is None:
        return front
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    # motif and plate share their outline
    kept = touching_vertices(front.motif.shape.mask) & touching_vertices(front.plate.shape.mask)
    for back in backs:
        if isinstance(back, FlatBack):
            kept |= rectangle_corners(back)
    pieces = [Thinning(front.motif, front.motif_edges, kept=kept), Thinning(front.plate, front.plate_edges, kept=kept)]
    limit = wanted = options.triangle_count
    while True:
        thinned, facts["max_error_mm"] = thin_pieces(pieces, error_mm, limit, options.triangles)
        (motif, motif_edges, _), (plate, plate_edges, _) = thinned
        found = RaisedFront(motif, plate, motif_edges, plate_edges)
        faces = RaisedPiece.of(found, backs[0]).face_count if backs else found.face_count
        if limit is None or wanted is None or faces <= wanted:
            return found
        limit -= faces - wanted  # the walls and the back need triangles, too

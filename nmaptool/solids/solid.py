"""A relief to triangles: an open surface, or closed bodies with walls and a back."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.units import Length
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.curved_back import hollow_back, shell_back
from nmaptool.solids.flat_back import FlatBack
from nmaptool.solids.integral import volume_below
from nmaptool.solids.outline import OutlineEdges, find_splits, outline_edges
from nmaptool.solids.pieces import pieces_of
from nmaptool.solids.shape import Shape, pixel_shape, pixels_touching
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import has_soft_edges, smooth_foot_line, smooth_shape
from nmaptool.solids.thinned_sheet import Surfaces, Thinning, thin_pieces
from nmaptool.solids.walls import wall_parts
from nmaptool.types.height import Height
from nmaptool.types.inputs import as_height
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Body, Part, Solid


def solid(relief: Height | Relief, options: SolidOptions | None = None) -> Solid:
    """Triangulate a relief: an open surface, or closed bodies with walls and a back.

    Every body is a manifold, whatever the mask: pixels that touch only at a corner do not share that corner.

    Parameters
    ----------
    relief : Height or Relief
        A relief has the coverage of its outline, a height field only its pixels.
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
    shape, facts = _shape_of(relief, height, options)
    height = _in_range(height, shape)
    zero_mm = _zero_of(relief, height)
    pieces = [_Piece.of(height, *placed, options, zero_mm) for placed in pieces_of(shape)] if options.is_closed else []
    if len(pieces) > 1 and options.one_piece:
        sizes = sorted(int(np.count_nonzero(piece.front.shape.mask)) for piece in pieces)
        raise InputError(
            f"`one_piece`: the relief has {len(pieces)} separate pieces, the largest of {sizes[-1]} px and the smallest "
            f"of {sizes[0]} px; connect them in the mask, or leave out `one_piece`"
        )
    if not options.is_closed:
        return _surface(height, shape, options, facts)
    thinned = _thinned([(piece.front, piece.edges, piece.back) for piece in pieces], height, options, facts)
    pieces = [_Piece(front, edges, back) for front, edges, back in thinned if back is not None]
    facts |= {"pieces": len(pieces)}
    bounds = np.array([piece.bounds_mm for piece in pieces])
    name = "relief" if len(pieces) == 1 else "relief {}"
    return Solid(
        tuple(piece.body(name.format(number)) for number, piece in enumerate(pieces, start=1)),
        True,
        np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)]),
        sum(piece.volume_mm3 for piece in pieces),
        facts,
    )


def _zero_of(relief: Height | Relief, height: Height) -> float:
    """The height that a base is measured from: the plate's, or the lowest of a relief without a plate."""
    if isinstance(relief, Relief) and relief.report.options.background != "plane":
        return height.range_mm[0]
    return 0.0


def _shape_of(relief: Height | Relief, height: Height, options: SolidOptions) -> tuple[Shape, dict[str, Any]]:
    """The shape of a relief's surface, and what was found."""
    mask = height.domain
    motif = relief.foreground if isinstance(relief, Relief) else mask
    coverage = relief.coverage if isinstance(relief, Relief) else None
    has_foot_line = mask.all() and not motif.all()
    edge = motif if has_foot_line else mask
    is_smooth = options.outline == "smooth" or (
        options.outline == "auto" and coverage is not None and has_soft_edges(edge, coverage)
    )
    if not is_smooth or edge.all():
        return pixel_shape(mask, find_splits(mask)), {"outline": "exact", "outline_deviation_mm": 0.0}
    moved = smooth_foot_line if has_foot_line else smooth_shape
    shape, deviation_px = moved(edge, edge.astype(np.float32) if coverage is None else coverage)
    return shape, {"outline": "smooth", "outline_deviation_mm": deviation_px * height.pitch_mm}


def _in_range(height: Height, shape: Shape) -> Height:
    """Heights whose range is kept by the moved nodes of the outline."""
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
    return Solid((body,), False, _bounds_of(sheet, edges), facts=facts)


def _thinned(
    surfaces: Sequence[Surfaces], height: Height, options: SolidOptions, facts: dict[str, Any]
) -> Sequence[Surfaces]:
    """The pieces with as many triangles as the options ask for."""
    if options.max_error is None and options.triangles is None:
        return surfaces
    error_mm = None if options.max_error is None else _in_mm(height)(options.max_error)
    pieces = [Thinning(*each) for each in surfaces]
    thinned, facts["max_error_mm"] = thin_pieces(pieces, error_mm, options.triangle_count, options.triangles)
    return thinned


def _bounds_of(sheet: Sheet, edges: OutlineEdges) -> Float64:
    """(2, 3) float64: the box around a sheet."""
    rim = sheet.xyz_of(edges.start)
    low, high = rim.min(axis=0), rim.max(axis=0)
    low[2], high[2] = sheet.z_range()
    return np.stack([low, high])


@dataclass(frozen=True, eq=False)
class _Piece:
    """A closed body: its front, its outline and its back."""

    front: Sheet
    edges: OutlineEdges
    back: Sheet | FlatBack

    @classmethod
    def of(cls, height: Height, shape: Shape, top: int, left: int, options: SolidOptions, zero_mm: float) -> _Piece:
        rows, cols = shape.mask.shape
        z_mm = height.z_mm[top : top + rows + 1, left : left + cols + 1]
        placing = Placing(height.pitch_mm, left, height.frame.rows - top - rows)
        front = Sheet(z_mm, shape, placing)
        edges = outline_edges(shape.mask, shape.splits)
        return cls(front, edges, _back_of(front, edges, height, options, zero_mm))

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around the body."""
        bounds = _bounds_of(self.front, self.edges)
        back = self.back
        bounds[0, 2] = back.z_mm if isinstance(back, FlatBack) else back.z_range()[0]
        return bounds

    @property
    def volume_mm3(self) -> float:
        """Between front and back, from the heights."""
        if isinstance(self.back, FlatBack):
            flat = Sheet(np.full_like(self.front.z_mm, self.back.z_mm), self.front.shape, self.front.placing)
            return volume_below(self.front) - volume_below(flat)
        return volume_below(self.front) - volume_below(self.back)

    def body(self, name: str) -> Body:
        """Its triangles."""
        faces = self.front.face_count + 2 * len(self.edges.start) + self.back.face_count
        return Body(name, self._parts, faces, self.back.node_count)

    def _parts(self) -> Iterator[Part]:
        yield from self.front.parts()
        edges, offset = self.edges, self.front.shape.node_count
        yield from wall_parts(edges.start, edges.end, self.front.xyz_of, self.back.xyz_of, offset)
        yield from self.back.parts()


def _back_of(
    front: Sheet, edges: OutlineEdges, height: Height, options: SolidOptions, zero_mm: float
) -> Sheet | FlatBack:
    """The back that the options ask for."""
    shape, first = front.shape, front.shape.node_count
    in_mm = _in_mm(height)
    if options.shell is not None:
        z_mm = shell_back(front.z_mm, shape.mask, in_mm(options.shell), height.pitch_mm)
        return Sheet(z_mm, shape, front.placing, -1, first)
    assert options.base is not None  # options are closed
    base_mm = in_mm(options.base) - zero_mm
    deepest = -front.z_range()[0]
    if deepest >= base_mm:
        raise InputError(
            f"`base='{options.base}'`: the relief reaches {deepest:.4g} mm below height 0, so its base must be thicker, "
            f"such as `base='{deepest + 1:.1f}mm'`"
        )
    if options.hollow is not None:
        z_mm = hollow_back(front.z_mm, shape.mask, in_mm(options.hollow), base_mm, height.pitch_mm)
        return Sheet(z_mm, shape, front.placing, -1, first)
    outline = np.zeros(shape.node_count, bool)
    outline[edges.start] = True
    beside = pixels_touching(shape.moved[outline[shape.moved]], shape)
    return FlatBack(shape, front.placing, -base_mm, first, edges, beside)


def _in_mm(height: Height):  # type: ignore[no-untyped-def]
    def in_mm(length: Length) -> float:
        return length.to_mm(height.pitch_mm, height.frame.longer_side)

    return in_mm

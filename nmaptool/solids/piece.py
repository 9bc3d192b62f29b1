"""One closed body of a solid: its front, its outline and its back."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.units import Length
from nmaptool.options import SolidOptions
from nmaptool.solids.curved_back import hollow_back, shell_back
from nmaptool.solids.flat_back import FlatBack
from nmaptool.solids.integral import volume_below
from nmaptool.solids.outline import OutlineEdges
from nmaptool.solids.shape import pixels_touching
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.walls import wall_parts
from nmaptool.types.height import Height
from nmaptool.types.solid import Body, Part

Back = Sheet | FlatBack


@dataclass(frozen=True, eq=False)
class Piece:
    """A closed body.

    Attributes
    ----------
    front : Sheet
    edges : OutlineEdges
    back : Sheet or FlatBack
        Its nodes follow those of the front.
    """

    front: Sheet
    edges: OutlineEdges
    back: Back

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around the body."""
        bounds = bounds_of(self.front, self.edges)
        bounds[0, 2] = lowest_of(self.back)
        return bounds

    @property
    def volume_mm3(self) -> float:
        """Between front and back, from the heights."""
        return volume_below(self.front) - volume_below_back(self.back)

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return self.front.face_count + 2 * len(self.edges.start) + self.back.face_count

    def body(self, name: str) -> Body:
        """Its triangles."""
        return Body(name, self._parts, self.face_count, self.back.node_count)

    def _parts(self) -> Iterator[Part]:
        yield from self.front.parts()
        edges, offset = self.edges, self.back.first_node
        yield from wall_parts(edges.start, edges.end, self.front.xyz_of, self.back.xyz_of, offset)
        yield from self.back.parts()


def bounds_of(sheet: Sheet, edges: OutlineEdges) -> Float64:
    """(2, 3) float64: the box around a sheet."""
    rim = sheet.xyz_of(edges.start)
    low, high = rim.min(axis=0), rim.max(axis=0)
    low[2], high[2] = sheet.z_range()
    return np.stack([low, high])


def lowest_of(back: Back) -> float:
    """The lowest height of a back."""
    return back.z_mm if isinstance(back, FlatBack) else back.z_range()[0]


def volume_below_back(back: Back) -> float:
    """The integral of the heights of a back in mm3."""
    if isinstance(back, FlatBack):
        flat = np.broadcast_to(np.float64(back.z_mm), (back.shape.mask.shape[0] + 1, back.shape.mask.shape[1] + 1))
        return volume_below(Sheet(flat, back.shape, back.placing, moved_z_mm=np.full(len(back.shape.moved), back.z_mm)))
    return volume_below(back)


def pocket_mm3(back: Back) -> float:
    """The volume above the lowest point of a back, such as that of a pocket."""
    if isinstance(back, FlatBack):
        return 0.0
    flat = np.broadcast_to(np.float64(lowest_of(back)), back.z_mm.shape)
    level = np.full(len(back.shape.moved), flat[0, 0])
    return volume_below(back) - volume_below(dataclasses.replace(back, z_mm=flat, moved_z_mm=level))


def back_of(front: Sheet, edges: OutlineEdges, height: Height, options: SolidOptions, zero_mm: float) -> Back:
    """The back that the options ask for.

    Parameters
    ----------
    front : Sheet
    edges : OutlineEdges
        Its outline, in edges of single pixels.
    height : Height
        For lengths in px and %.
    options : SolidOptions
        They are closed.
    zero_mm : float
        Height that the base is measured from.

    Raises
    ------
    InputError
        If the base is thinner than the relief is deep.
    """
    shape, first = front.shape, front.node_count
    if options.shell is not None:
        z_mm = shell_back(front.z_mm, shape.mask, in_mm(options.shell, height), height.pitch_mm)
        # moved nodes are as far behind the front as the vertices that they come from
        behind = front.z_of_moved - (front.z_mm - z_mm).ravel()[shape.vertex_of(shape.moved)]
        return Sheet(z_mm, shape, front.placing, -1, first, behind, diagonals_of=front)
    base_mm = base_below(height, options, zero_mm, front.z_range()[0])
    if options.hollow is not None:
        z_mm = hollow_back(front.z_mm, shape.mask, in_mm(options.hollow, height), base_mm, height.pitch_mm)
        moved = z_mm.ravel()[shape.vertex_of(shape.moved)]
        return Sheet(z_mm, shape, front.placing, -1, first, moved, diagonals_of=front)
    outline = np.zeros(shape.node_count, bool)
    outline[edges.start] = True
    on = outline[shape.moved]  # nodes of a foot line stay on the grid
    flat = dataclasses.replace(shape, moved=shape.moved[on], by_px=shape.by_px[on])
    return FlatBack(flat, front.placing, -base_mm, first, edges, pixels_touching(flat.moved, flat))


def base_below(height: Height, options: SolidOptions, zero_mm: float, lowest_mm: float) -> float:
    """How far a flat back lies below height 0, in mm; the lowest point of the front must lie above it."""
    assert options.base is not None
    return check_base(options, in_mm(options.base, height) - zero_mm, lowest_mm)


def check_base(options: SolidOptions, base_mm: float, lowest_mm: float) -> float:
    """Refuse a base that lies above the lowest point of the front, both in mm below height 0."""
    if -lowest_mm >= base_mm:
        raise InputError(
            f"`base='{options.base}'`: the relief reaches {-lowest_mm:.4g} mm below height 0, so its base must be "
            f"thicker, such as `base='{1 - lowest_mm:.1f}mm'`"
        )
    return base_mm


def in_mm(length: Length, height: Height) -> float:
    """A length in mm on a height field."""
    return length.to_mm(height.pitch_mm, height.frame.longer_side)

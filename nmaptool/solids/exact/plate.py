"""A plate with an exact outline: its front, its walls and its back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.solids.exact.plate_walls import walls_to_corners
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.solids.exact.strip import Strip, outline_area
from nmaptool.solids.integral import volume_below
from nmaptool.solids.raised import RaisedFront
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.walls import wall_parts
from nmaptool.types.solid import Body, Faces, Nodes, Part


@dataclass(frozen=True, eq=False)
class PlateFront:
    """The front: pixels, and the strip between them and the outline.

    The points of the outline are numbered after the nodes of the pixels.

    Attributes
    ----------
    surface : Sheet or RaisedFront
    strip : Strip
    z_mm : (n,) float64
        Heights of the points of the outline.
    """

    surface: Sheet | RaisedFront
    strip: Strip
    z_mm: Float64

    @property
    def rim(self) -> Sheet:
        """The sheet that the strip joins."""
        return self.surface.plate if isinstance(self.surface, RaisedFront) else self.surface

    @property
    def first_point(self) -> int:
        """Node number of the first point of the outline."""
        return self.surface.node_count

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.first_point + len(self.z_mm)

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return self.surface.face_count + len(self.strip.faces)

    @property
    def volume_mm3(self) -> float:
        """Between the front and height 0."""
        surface = self.surface
        sheets = [surface.motif, surface.plate] if isinstance(surface, RaisedFront) else [surface]
        return sum(volume_below(sheet) for sheet in sheets) + self.strip.volume_below(self.rim, self.z_mm)

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around it."""
        surface, xy_mm = self.surface, self.strip.points.xy_mm
        low, high = self.strip.z_range(self.rim, self.z_mm)
        if isinstance(surface, RaisedFront):
            motif_low, motif_high = surface.motif.z_range()
            low, high = min(low, motif_low), max(high, motif_high)
        return np.array([[*xy_mm.min(axis=0), low], [*xy_mm.max(axis=0), high]])

    def parts(self) -> Iterator[Part]:
        """The triangles."""
        yield from self.surface.parts()
        yield self.strip.part(self.rim, self.z_mm, self.first_point)


@dataclass(frozen=True, eq=False)
class FlatPlateBack:
    """A flat back through the corners of the outline.

    Attributes
    ----------
    z_mm : (c,) float64
        Its height at each corner.
    corners : OutlinePoints
    faces : (m, 3) int64
        Seen from the viewer.
    first_point : int
        Node number of the first corner.
    """

    z_mm: Float64
    corners: OutlinePoints
    faces: Nodes
    first_point: int

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.first_point + len(self.z_mm)

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    @property
    def lowest_mm(self) -> float:
        """Height of its lowest point."""
        return float(self.z_mm[0])

    @property
    def volume_mm3(self) -> float:
        """Between the back and height 0."""
        return self.lowest_mm * outline_area(self.corners)

    @property
    def xyz_mm(self) -> Float64:
        """(c, 3) float64: its corners."""
        return np.column_stack([self.corners.xy_mm, self.z_mm])

    def parts(self) -> Iterator[Part]:
        """The triangles, seen from below."""
        faces: Faces = self.faces[:, ::-1].astype(np.int32)
        yield Part(self.xyz_mm, faces, self.first_point + np.arange(len(self.z_mm)))


@dataclass(frozen=True, eq=False)
class CurvedPlateBack:
    """A back of pixels and a strip, as the front's: a shell or a pocket.

    Attributes
    ----------
    sheet : Sheet
        Its nodes follow the points of the outline.
    strip : Strip
    z_mm : (n,) float64
        Heights of the points of the outline.
    """

    sheet: Sheet
    strip: Strip
    z_mm: Float64

    @property
    def first_point(self) -> int:
        """Node number of the first point of the outline."""
        return self.sheet.first_node - len(self.z_mm)

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.sheet.node_count

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return self.sheet.face_count + len(self.strip.faces)

    @property
    def lowest_mm(self) -> float:
        """Height of its lowest point."""
        return self.strip.z_range(self.sheet, self.z_mm)[0]

    @property
    def volume_mm3(self) -> float:
        """Between the back and height 0."""
        return volume_below(self.sheet) + self.strip.volume_below(self.sheet, self.z_mm)

    def parts(self) -> Iterator[Part]:
        """The triangles, seen from below."""
        yield self.strip.part(self.sheet, self.z_mm, self.first_point)
        yield from self.sheet.parts()


PlateBack = FlatPlateBack | CurvedPlateBack


@dataclass(frozen=True, eq=False)
class PlatePiece:
    """A closed body with an exact outline.

    Attributes
    ----------
    front : PlateFront
    back : FlatPlateBack or CurvedPlateBack
        Its nodes follow those of the front.
    """

    front: PlateFront
    back: PlateBack

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around the body."""
        bounds = self.front.bounds_mm
        bounds[0, 2] = self.back.lowest_mm
        return bounds

    @property
    def volume_mm3(self) -> float:
        """Between front and back, from the heights."""
        return self.front.volume_mm3 - self.back.volume_mm3

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        walls = len(self.front.z_mm) + len(self.back.z_mm)
        return self.front.face_count + walls + self.back.face_count

    def body(self, name: str) -> Body:
        """Its triangles."""
        return Body(name, self._parts, self.face_count, self.back.node_count)

    def _parts(self) -> Iterator[Part]:
        yield from self.front.parts()
        yield from self._walls()
        yield from self.back.parts()

    def _walls(self) -> Iterator[Part]:
        points, back, first = self.front.strip.points, self.back, self.front.first_point
        count = len(points.xy_mm)
        front_mm = np.column_stack([points.xy_mm, self.front.z_mm])
        if isinstance(back, FlatPlateBack):
            xyz_mm = np.concatenate([front_mm, back.xyz_mm])
            numbers = np.concatenate([first + np.arange(count), back.first_point + np.arange(len(back.z_mm))])
            yield Part(xyz_mm, self._walls_to_corners, numbers)
            return
        back_mm = np.column_stack([points.xy_mm, back.z_mm])
        yield from wall_parts(
            first + np.arange(count),
            first + points.after,
            lambda nodes: front_mm[nodes - first],
            lambda nodes: back_mm[nodes - first],
            back.first_point - first,
        )

    @cached_property
    def _walls_to_corners(self) -> Faces:
        points, pitch_mm = self.front.strip.points, self.front.rim.placing.pitch_mm
        return walls_to_corners(points, self.front.z_mm, self.back.lowest_mm, pitch_mm).astype(np.int32)

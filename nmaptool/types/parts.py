"""Parts of a relief: rectangles of its pixels."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.types.picture import Frame
from nmaptool.types.solid import Solid


@dataclass(frozen=True)
class PlannedPart:
    """Where a part of a relief lies.

    Neighbours share the vertices of the grid along the line between them.

    Attributes
    ----------
    row, col : int
        From 0 at the upper left.
    top, bottom, left, right : int
        Pixels of the whole: the first row, one more than the last, the same of the columns.
    """

    row: int
    col: int
    top: int
    bottom: int
    left: int
    right: int

    @property
    def rows(self) -> slice:
        """Its rows of pixels."""
        return slice(self.top, self.bottom)

    @property
    def cols(self) -> slice:
        """Its columns of pixels."""
        return slice(self.left, self.right)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of pixels."""
        return self.bottom - self.top, self.right - self.left

    def size_mm(self, pitch_mm: float) -> tuple[float, float]:
        """Width and height."""
        return (self.right - self.left) * pitch_mm, (self.bottom - self.top) * pitch_mm


@dataclass(frozen=True)
class PlacedPart:
    """A finished part, as the assembly lists it.

    Attributes
    ----------
    row, col : int
        From 0 at the upper left.
    low_mm, high_mm : (float, float, float)
        Least and greatest x, y and z in the frame of the whole.
    files : tuple of str
        File names, without folders.
    triangles, bodies : int
    volume_mm3 : float or None
        None for an open surface.
    """

    row: int
    col: int
    low_mm: tuple[float, float, float]
    high_mm: tuple[float, float, float]
    files: tuple[str, ...]
    triangles: int
    bodies: int
    volume_mm3: float | None

    @property
    def size_mm(self) -> tuple[float, float, float]:
        """Extent along x, y and z."""
        x, y, z = (high - low for low, high in zip(self.low_mm, self.high_mm, strict=True))
        return x, y, z


@dataclass(frozen=True)
class Assembly:
    """Which part of a relief goes where.

    Attributes
    ----------
    size_mm : (float, float)
        Width and height of the whole.
    rows, cols : int
        Rows and columns of parts.
    origin : str
        Where the coordinates in the files begin, as in `PartOptions.part_origin`.
    parts : tuple of PlacedPart
        From the top, and from the left in each row.
    left_out : tuple of (int, int)
        Row and column of parts that hold nothing of the relief.
    cuts_x_mm, cuts_y_mm : tuple of float
        Where the lines between parts lie, borders included: x from the left, y from the top.
    """

    size_mm: tuple[float, float]
    rows: int
    cols: int
    origin: str
    parts: tuple[PlacedPart, ...]
    left_out: tuple[tuple[int, int], ...]
    cuts_x_mm: tuple[float, ...]
    cuts_y_mm: tuple[float, ...]

    @property
    def volume_mm3(self) -> float | None:
        """All parts together; None for open surfaces."""
        volumes = [part.volume_mm3 for part in self.parts]
        return None if None in volumes else sum(volume for volume in volumes if volume is not None)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; lengths are in mm, x to the right and y up from the lower left corner of the whole."""
        found = dataclasses.asdict(self)
        for entry, part in zip(found["parts"], self.parts, strict=True):
            entry["size_mm"] = part.size_mm
        return {"kind": "parts", "unit": "mm", "volume_mm3": self.volume_mm3, **found}


def assembly_of(
    frame: Frame, origin: str, plan: Sequence[PlannedPart], placed: Mapping[tuple[int, int], PlacedPart]
) -> Assembly:
    """The assembly of a plan; parts that are not placed are left out.

    Parameters
    ----------
    frame : Frame
        Of the whole; the pitch is known.
    origin : str
    plan : sequence of PlannedPart
    placed : mapping of (row, col) to PlacedPart
    """
    assert frame.pitch_mm is not None
    pitch_mm = frame.pitch_mm
    rights, bottoms = sorted({part.right for part in plan}), sorted({part.bottom for part in plan})
    places = [(part.row, part.col) for part in plan]
    return Assembly(
        (frame.cols * pitch_mm, frame.rows * pitch_mm),
        len(bottoms),
        len(rights),
        origin,
        tuple(placed[place] for place in places if place in placed),
        tuple(place for place in places if place not in placed),
        (min(part.left for part in plan) * pitch_mm, *(right * pitch_mm for right in rights)),
        (min(part.top for part in plan) * pitch_mm, *(bottom * pitch_mm for bottom in bottoms)),
    )


def placed_part(part: PlannedPart, frame: Frame, origin: str, solid: Solid, files: Sequence[str] = ()) -> PlacedPart:
    """The entry of a part in the assembly.

    Parameters
    ----------
    part : PlannedPart
    frame : Frame
        Of the whole; the pitch is known.
    origin : str
        Where the coordinates of ``solid`` begin.
    solid : Solid
    files : sequence of str
        File names.
    """
    assert frame.pitch_mm is not None
    bounds = solid.bounds_mm.copy()
    if origin == "own":
        bounds[:, :2] += np.array([part.left, frame.rows - part.bottom]) * frame.pitch_mm
    low, high = ((float(x), float(y), float(z)) for x, y, z in bounds)
    volume = float(solid.volume_mm3) if solid.is_closed else None
    bodies = len(solid.bodies)
    return PlacedPart(part.row, part.col, low, high, tuple(files), solid.face_count, bodies, volume)

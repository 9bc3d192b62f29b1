"""What every part of a relief must know of the whole: its size, its back, and how it is placed."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nmaptool.core.errors import InputError
from nmaptool.core.units import Length
from nmaptool.options.parts import PartOrigin
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.piece import check_base
from nmaptool.solids.sheet import Placing
from nmaptool.types.parts import PlannedPart
from nmaptool.types.picture import Frame

_LENGTHS = ("base", "shell", "hollow", "max_error")
# the diagonals of pixels on the border depend on the vertices beyond, and these on the pixels around them
_RING_PX = 2


@dataclass(frozen=True)
class PartFrame:
    """The whole of a relief, as far as its parts depend on it.

    Parameters
    ----------
    frame : Frame
        Size in pixels; the pitch is known.
    low_mm, high_mm : float
        The lowest and the highest point of the whole.
    options : SolidOptions
        Lengths in % refer to the longer side of the whole.
    zero_mm : float
        Height that the base is measured from: 0 for a relief on a plate, else ``low_mm``.
    origin : str
        Where the coordinates of a part begin, as in `PartOptions.part_origin`.

    Raises
    ------
    InputError
        If the pitch is not known, the heights are not finite or not in order, or the base is thinner than the relief is
        deep.
    """

    frame: Frame
    low_mm: float
    high_mm: float
    options: SolidOptions = dataclasses.field(default_factory=SolidOptions)
    zero_mm: float = 0.0
    origin: PartOrigin = "whole"

    def __post_init__(self) -> None:
        if self.frame.pitch_mm is None:
            raise InputError("parts need a pixel size in mm; set pitch_mm of the frame of the whole")
        if not (math.isfinite(self.low_mm) and math.isfinite(self.high_mm) and self.low_mm <= self.high_mm):
            raise InputError(
                f"the heights of the whole are {self.low_mm:g} to {self.high_mm:g} mm; expected low to high"
            )
        if self.options.base is not None:
            check_base(self.options, self._in_mm(self.options.base) - self.zero_mm, self.low_mm)

    @property
    def pitch_mm(self) -> float:
        """Millimetres per pixel."""
        assert self.frame.pitch_mm is not None  # checked at construction
        return self.frame.pitch_mm

    @cached_property
    def solid(self) -> SolidOptions:
        """The options with all lengths in mm."""
        given = {name: length for name in _LENGTHS if (length := getattr(self.options, name)) is not None}
        in_mm: dict[str, Any] = {name: Length(self._in_mm(length), "mm") for name, length in given.items()}
        return dataclasses.replace(self.options, **in_mm)

    @property
    def ring_px(self) -> int:
        """How many pixels around a part its triangles depend on."""
        if self.options.shell is None:
            return _RING_PX
        return _RING_PX + math.ceil(self._in_mm(self.options.shell) / self.pitch_mm)

    def window_of(self, part: PlannedPart) -> tuple[slice, slice]:
        """The rows and columns of pixels that `part_of` needs: the part, and `ring_px` pixels around it."""
        ring, rows, cols = self.ring_px, self.frame.rows, self.frame.cols
        return (
            slice(max(part.top - ring, 0), min(part.bottom + ring, rows)),
            slice(max(part.left - ring, 0), min(part.right + ring, cols)),
        )

    def placing(self, part: PlannedPart, top: int, left: int, rows: int) -> Placing:
        """The place of a grid of pixels of a part, from its upper left corner in the whole and its rows."""
        if self.origin == "own":
            return Placing(self.pitch_mm, left - part.left, part.bottom - top - rows)
        return Placing(self.pitch_mm, left, self.frame.rows - top - rows)

    def _in_mm(self, length: Length) -> float:
        return length.to_mm(self.pitch_mm, self.frame.longer_side)

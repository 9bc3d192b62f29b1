"""Options for the parts of a relief: how large they are, and where their coordinates begin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import CountsText, parse_counts
from nmaptool.options.length_kinds import SidesText, parse_sides

PartOrigin = Literal["whole", "own"]


@dataclass(frozen=True)
class PartOptions(Options, group="Parts"):
    """How a relief is cut into parts that fit each other.

    Parameters
    ----------
    part:
        Cut the relief into equal parts of at most this size, such as 400mm, or 600x400mm for width and height.
        Neighbours share their border exactly, and all parts have the same back. Name the files with {row} and {col},
        such as -o 'parts/{row}_{col}.stl'; rows count from the top, columns from the left, both from 0.
    parts:
        Cut the relief into this many parts across and down, such as 3x4. Use it instead of --part.
    part_origin:
        Where the coordinates of a part begin: "whole" at the lower left corner of the relief, so that the files
        assemble when they are loaded together; "own" at the lower left corner of the part.
    """

    part: str | None = option(None, SidesText("400mm"))
    parts: str | None = option(None, CountsText("3x4"))
    part_origin: PartOrigin = option("whole", choice_of(PartOrigin, "own"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.part is not None and self.parts is not None:
            raise UsageError("`part` and `parts` both set how large the parts are; give one of them")
        if self.part_origin != "whole" and not self.is_given:
            raise UsageError(f"`part_origin='{self.part_origin}'`: needs parts, such as `part='400mm'`")

    @property
    def is_given(self) -> bool:
        """Whether there are parts."""
        return self.part is not None or self.parts is not None

    @property
    def largest_mm(self) -> tuple[float, float] | None:
        """Width and height of ``part`` in mm; None if it is not given."""
        return None if self.part is None else parse_sides("part", self.part)

    @property
    def counts(self) -> tuple[int, int] | None:
        """How many parts there are across and down by ``parts``; None if it is not given."""
        return None if self.parts is None else parse_counts("parts", self.parts)

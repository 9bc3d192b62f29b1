"""Options for the shape of a plate, its holes and its loop."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset, length
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import NameOrFile, Number, SignedText, Switch, Text
from nmaptool.options.length_kinds import LengthText, OffsetText, parse_distances

Fill = Literal["auto", "inside", "cover"]

# the shapes that are made here
SHAPES = {
    "rect": "a rectangle",
    "round": "a disc",
    "oval": "an ellipse",
    "mask": "the motif's own outline, at the distance of the margin",
}
SHAPE = NameOrFile("shield.svg", SHAPES)
_ASPECT = re.compile(r"\s*(\d+\.?\d*)\s*[:/x]\s*(\d+\.?\d*)\s*")
_MOST_ELONGATED = 20.0


@dataclass(frozen=True)
class Hole:
    """A round hole: its diameter, and its middle across and down from the upper left corner of the plate."""

    diameter: Length
    across: Offset
    down: Offset


@dataclass(frozen=True)
class PlateOptions(Options, group="Plate"):
    """The plate that carries the motif.

    With a plate, --width is the width of the plate, and % are per cent of its longer side.

    Parameters
    ----------
    shape:
        Make a plate with an exact outline: one of these shapes, or that of an SVG file with one closed path.
    aspect:
        Width to height of a rect or oval plate, such as 3:4. Default: that of the motif.
    margin:
        Space between the motif and the frame, the lettering along the edge, or the edge. Default: 4%, beside lettering
        1.5%.
    fill:
        "inside": the motif lies wholly inside the frame. "cover": the picture covers the plate and is cropped to it.
        "auto": inside, unless the motif fills the picture.
    corner:
        Radius of the corners of a rect plate, such as 3mm. Default: sharp.
    hole:
        Round hole: DIAMETER@ACROSS,DOWN from the upper left corner of the plate, such as 4mm@50%,6mm. Separate several
        by semicolons.
    hole_rim:
        Width of the raised rim around a hole, such as 1mm; 0 for none. Default: a fifth of the diameter.
    loop:
        Add a loop above the plate, for a pendant, with an eye of this diameter, such as 3mm.
    engrave:
        Sink the motif into the plate instead of raising it.
    emboss:
        Raise the motif above the plate. This is the default; it replaces engrave of a preset or recipe.
    draft:
        Slope of the sides of frame and letters, in degrees from upright, so that they can be cast, struck or milled.
    """

    shape: str | None = option(None, SHAPE)
    aspect: str | None = option(None, Text("3:4"))
    margin: Length | None = option(None, LengthText("5mm"))
    fill: Fill = option("auto", choice_of(Fill, "cover"))
    corner: Length | None = option(None, LengthText("3mm"))
    hole: str | None = option(None, SignedText("4mm@50%,6mm"))
    hole_rim: Offset | None = option(None, OffsetText("1mm"))
    loop: Length | None = option(None, LengthText("3mm"))
    engrave: bool = option(False, Switch())
    emboss: bool = option(False, Switch())
    draft: float = option(12.0, Number("12", 0.0, 60.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.aspect is not None and self.shape not in (None, "rect", "oval"):
            raise UsageError(f"`aspect={self.aspect!r}`: is for `shape='rect'` or `shape='oval'`, not {self.shape}")
        if self.corner is not None and self.shape not in (None, "rect"):
            raise UsageError(f"`corner='{self.corner}'`: is for `shape='rect'`, not {self.shape}")
        if self.engrave and self.emboss:
            raise UsageError("`engrave` and `emboss` exclude each other; give one of them")
        _ = self.proportion, self.holes
        if self.shape is None:
            self._refuse_without_shape()

    def _refuse_without_shape(self) -> None:
        for name in ("aspect", "margin", "corner", "hole", "hole_rim", "loop"):
            value = getattr(self, name)
            if value is not None:
                raise UsageError(f"`{name}='{value}'`: needs a plate, such as `shape='round'`")
        if self.fill != "auto":
            raise UsageError(f"`fill='{self.fill}'`: needs a plate, such as `shape='round'`")

    @property
    def is_drawn(self) -> bool:
        """Whether the shape is an SVG file."""
        return self.shape is not None and SHAPE.is_file(self.shape)

    @property
    def proportion(self) -> float | None:
        """Width divided by height; None if it is that of the motif."""
        if self.aspect is None:
            return None
        match = _ASPECT.fullmatch(self.aspect)
        across, down = (float(match[1]), float(match[2])) if match else (0.0, 0.0)
        if not (down and 1 / _MOST_ELONGATED <= across / down <= _MOST_ELONGATED):
            raise UsageError(
                f"`aspect={self.aspect!r}`: expected width:height up to {_MOST_ELONGATED:g}:1, such as 3:4"
            )
        return across / down

    @property
    def holes(self) -> tuple[Hole, ...]:
        """The holes of ``hole``."""
        if self.hole is None:
            return ()
        return tuple(_hole(text) for text in self.hole.split(";") if text.strip())


def _hole(text: str) -> Hole:
    size, found, place = text.strip().partition("@")
    try:
        if not found:
            raise UsageError("")
        return Hole(length(size), *parse_distances("hole", place, (2,), "50%,6mm"))
    except UsageError:
        raise UsageError(f"`hole={text.strip()!r}`: expected DIAMETER@ACROSS,DOWN, such as 4mm@50%,6mm") from None

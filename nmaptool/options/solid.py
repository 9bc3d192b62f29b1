"""Options for the triangles of a relief: closed or open, their outline, their number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import ManyText, Switch, parse_many
from nmaptool.options.length_kinds import LengthText

Outline = Literal["auto", "exact", "smooth"]


@dataclass(frozen=True)
class SolidOptions(Options, group="Solid"):
    """How a relief becomes triangles.

    Parameters
    ----------
    base:
        Close the surface to a solid with walls and a flat back. The back lies this far below the plate, or below the
        lowest point of a relief without a plate (--background cut, free or surface), such as 2mm. Default: the surface
        stays open.
    shell:
        Close the surface to a shell of this thickness, whose back follows the front, such as 1.5mm. Use it instead of
        --base.
    hollow:
        Hollow the solid of --base from the back, and leave this wall thickness, such as 1.2mm.
    outline:
        Outline of a motif that is cut out (--background cut): "exact" follows the pixels, "smooth" runs along the edge
        that the soft pixels of the mask or map describe. "auto" is smooth where there are soft pixels.
    one_piece:
        Refuse a relief that would fall apart into several pieces.
    max_error:
        Leave out triangles as long as the surface stays within this height of the full grid, such as 0.01mm. Default:
        two triangles for each pixel.
    triangles:
        Leave out triangles until at most this many remain, such as 200k, with the smallest possible error.
    """

    base: Length | None = option(None, LengthText("2mm"))
    shell: Length | None = option(None, LengthText("1.5mm"))
    hollow: Length | None = option(None, LengthText("1.2mm"))
    outline: Outline = option("auto", choice_of(Outline, "smooth"))
    one_piece: bool = option(False, Switch())
    max_error: Length | None = option(None, LengthText("0.01mm"))
    triangles: str | None = option(None, ManyText("200k", low=100))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.base is not None and self.shell is not None:
            raise UsageError("`base` and `shell` are two kinds of back; give one of them")
        if self.hollow is not None and self.base is None:
            raise UsageError(f"`hollow='{self.hollow}'`: needs `base`, such as `base='3mm'`")
        if self.max_error is not None and self.triangles is not None:
            raise UsageError("`max_error` and `triangles` both set how many triangles remain; give one of them")

    @property
    def triangle_count(self) -> int | None:
        """``triangles`` as a number; None if it is not given."""
        return None if self.triangles is None else parse_many("triangles", self.triangles)

    @property
    def is_closed(self) -> bool:
        """Whether the surface becomes a solid."""
        return self.base is not None or self.shell is not None

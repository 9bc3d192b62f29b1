"""Options for pictures of reliefs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset, offset
from nmaptool.options.bake import Up
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, Count, Kind, Switch, Text
from nmaptool.options.length_kinds import LengthText
from nmaptool.options.materials import material_choices

View = Literal["top", "iso"]
Axis = Literal["x", "y"]
_STRONGEST = 10.0
_SMALLEST_PX, _LARGEST_PX = 16, 8000
_SMALLEST_PLOT_PX = 240


@dataclass(frozen=True)
class Light:
    """A lamp far away.

    Parameters
    ----------
    azimuth_deg : float
        Counter-clockwise from the right: 90 is above the picture, 180 to its left.
    elevation_deg : float
        Above the plate, 0 to 90.
    strength : float
        Light on a level plate, relative to the usual first light.
    """

    azimuth_deg: float
    elevation_deg: float
    strength: float = 1.0


def parse_light(text: str) -> Light:
    """Read ``135,38``, or ``135,38,0.5`` with a strength.

    Raises
    ------
    UsageError
        If the text is something else, the elevation is not between 0 and 90, or the strength not between 0 and 10.
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (2, 3) or not all(map(math.isfinite, values)):
        raise UsageError(
            f"`light={text!r}`: expected azimuth and elevation in degrees, such as 135,38, and a strength if wanted"
        )
    light = Light(*values)
    if not 0 < light.elevation_deg <= 90:
        raise UsageError(
            f"`light={text!r}`: an elevation of {light.elevation_deg:g} degrees is not above the plate; it must be "
            "more than 0 and at most 90, such as 135,38"
        )
    if not 0 <= light.strength <= _STRONGEST:
        raise UsageError(f"`light={text!r}`: a strength of {light.strength:g} must lie between 0 and {_STRONGEST:g}")
    return light


@dataclass(frozen=True)
class Lights(Kind):
    """Any number of lights, each as text such as 135,38."""

    signed: ClassVar[bool] = True

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        texts = (value,) if isinstance(value, str) else tuple(value)
        for text in texts:
            parse_light(text)
        return texts


def parse_section(text: str) -> tuple[Axis, Offset]:
    """Read ``y=50%`` or ``x=12mm``: the axis that is constant along the cut, and where.

    Raises
    ------
    UsageError
        If the text is something else.
    """
    axis, _, place = text.partition("=")
    try:
        if axis.strip() in ("x", "y"):
            return ("x" if axis.strip() == "x" else "y"), offset(place)
    except UsageError:
        pass
    raise UsageError(f"`section={text!r}`: expected x or y and a place, such as y=50% or x=12mm")


@dataclass(frozen=True)
class SectionText(Text):
    """Where a section is cut, such as y=50%."""

    such_as: str = "y=50%"

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        parse_section(value)
        return value


@dataclass(frozen=True)
class PreviewOptions(Options, group="Picture"):
    """What a picture of a relief shows.

    Parameters
    ----------
    material:
        What the relief is made of.
    light:
        A light as azimuth,elevation in degrees; the azimuth turns counter-clockwise from the right: 135 is the upper
        left. A third number is its strength, 1 for the usual first light. Repeat the flag for several lights.
    view:
        "top": from straight above, to scale. "iso": a perspective picture of the piece with its thickness.
    up:
        Axis of a mesh that points up from the table: "z" for reliefs, "y" for most figures.
    section:
        Plot a cut instead: y=50% from left to right through the middle, x=12mm from bottom to top at 12 mm from the
        left. The axes are in mm.
    turntable:
        Film of the piece turning once, seen as by "iso".
    light_sweep:
        Film of the first light going once around the relief.
    frames:
        Pictures in a film.
    size:
        Longer side in pixels. Default: that of the relief, enlarged by a whole number to at least 900 and reduced to at
        most 2000 (1400 in perspective); 640 for films and in contact sheets.
    background:
        Colour around the piece, such as "#e8e4dc". "auto" suits the material.
    thickness:
        Thickness of the plate below its lowest point, for "iso", its shadow and sections; meshes have their own.
        Default: 4 % of the longer side.
    """

    material: str = option("clay", Choice("bronze", material_choices))
    light: tuple[str, ...] = option(("135,38", "15,22,0.25"), Lights())
    view: View = option("top", choice_of(View))
    up: Up = option("z", choice_of(Up))
    section: str | None = option(None, SectionText())
    turntable: bool = option(False, Switch())
    light_sweep: bool = option(False, Switch())
    frames: int = option(36, Count(low=2, high=1000))
    size: int | None = option(None, Count("1200", low=_SMALLEST_PX, high=_LARGEST_PX))
    background: str = option("auto", Text("#e8e4dc"))
    thickness: Length | None = option(None, LengthText("3mm", absolute=True, sets="the thickness of the plate"))

    def __post_init__(self) -> None:
        super().__post_init__()
        parse_background(self.background)
        chosen = [name for name in ("section", "turntable", "light_sweep") if getattr(self, name)]
        if len(chosen) > 1:
            raise UsageError(f"`{chosen[0]}` and `{chosen[1]}`: only one of them fits in a picture; leave one out")
        if self.section is not None and self.size is not None and self.size < _SMALLEST_PLOT_PX:
            raise UsageError(f"`size={self.size}`: a section with its axes needs at least {_SMALLEST_PLOT_PX} px")
        if self.section is not None and self.view == "iso":
            raise UsageError("`section` is a plot, and `view='iso'` a picture; leave one out")

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights as numbers."""
        return tuple(parse_light(text) for text in self.light)

    @property
    def is_film(self) -> bool:
        """Whether the result is a film."""
        return self.turntable or self.light_sweep


def parse_background(text: str) -> tuple[float, float, float] | None:
    """Linear RGB of a colour such as ``#e8e4dc``; None for "auto".

    Raises
    ------
    UsageError
        If the text is something else.
    """
    if text == "auto":
        return None
    try:
        if len(text) != 7 or text[0] != "#":
            raise ValueError
        codes = [int(text[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    except ValueError:
        raise UsageError(f"`background={text!r}`: use auto, or a colour such as #e8e4dc") from None
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in codes]
    return linear[0], linear[1], linear[2]

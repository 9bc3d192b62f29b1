"""How maps are blended, placed and composed.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset, length, offset, offsets
from nmaptool.options.checks import parse_size, require_absolute, require_at_least_zero, require_choices, require_number

BlendMode = Literal["rnm", "pd", "whiteout", "udn", "linear", "overlay"]
LayerMode = Literal["over", "rnm", "pd", "whiteout", "udn", "linear", "overlay"]
Anchor = Literal[
    "center", "top-left", "top", "top-right", "left", "right", "bottom-left", "bottom", "bottom-right"
]  # fmt: skip
Clip = Literal["auto", "yes", "no"]
Ground = Literal["clear", "flat"]

BLEND_MODES = ("rnm", "pd", "whiteout", "udn", "linear", "overlay")
LAYER_MODES = ("over", *BLEND_MODES)
# share of the width and height at which each anchor lies
ANCHORS = {
    "center": (0.5, 0.5),
    "top-left": (0.0, 0.0),
    "top": (0.5, 0.0),
    "top-right": (1.0, 0.0),
    "left": (0.0, 0.5),
    "right": (1.0, 0.5),
    "bottom-left": (0.0, 1.0),
    "bottom": (0.5, 1.0),
    "bottom-right": (1.0, 1.0),
}
_SMALLEST_SCALE, _LARGEST_SCALE = 1e-3, 1e3


def parse_scale(text: str, flag: str = "--scale") -> tuple[float, float] | Length:
    """``0.5``, ``0.5,0.7`` (across, down) or a width such as ``30mm``."""
    parts = text.split(",")
    try:
        factors = [float(part) for part in parts]
    except ValueError:
        if len(parts) == 1:
            try:
                return length(text)
            except UsageError:
                pass
        raise UsageError(f"{flag} {text!r}: expected a factor, two with a comma, or a width such as 30mm") from None
    if len(factors) > 2 or not all(_SMALLEST_SCALE <= f <= _LARGEST_SCALE for f in factors):
        raise UsageError(
            f"{flag} {text}: expected one or two factors between {_SMALLEST_SCALE:g} and {_LARGEST_SCALE:g}, "
            "such as 0.5"
        )
    return factors[0], factors[-1]


@dataclass(frozen=True)
class BlendOptions:
    """How a detail map is blended with a base map.

    Parameters
    ----------
    mode:
        "rnm" turns the detail with the base and undoes what bake writes; "pd" adds slopes, and two surfaces stay a
        surface; "whiteout" and "udn" are cheaper; "linear" and "overlay" are what image editors do.
    strength:
        How much of the detail: 0 none, 1 all, 2 twice as steep.
    fit:
        Stretch a detail map of another size to the base's.
    """

    mode: BlendMode = "rnm"
    strength: float = 1.0
    fit: bool = False

    def __post_init__(self) -> None:
        require_choices(("mode", self.mode, BLEND_MODES))
        require_at_least_zero(strength=self.strength)


@dataclass(frozen=True)
class LayerOptions:
    """Where a layer lies and how it is blended with what lies below.

    Parameters
    ----------
    name:
        What to call the layer. Default: its file.
    mode:
        "over" covers what is below; the others blend with it, as in blend.
    strength:
        How much of the layer, 0 to 1 for "over"; the others as in blend.
    at:
        Where the layer's anchor goes: across,down from the top left corner, such as 30%,12mm; % are of the canvas's
        width and height. Default: the same anchor of the canvas.
    anchor:
        The point of the layer that is placed, scaled and turned about: "center", "top-left", "top", "top-right",
        "left", "right", "bottom-left", "bottom" or "bottom-right".
    scale:
        Factor, or two (across,down), or the width that the layer's picture gets, such as 30mm.
    rotate:
        Degrees counter-clockwise.
    flip_h:
        Mirror left and right.
    flip_v:
        Mirror top and bottom.
    feather:
        Width of the soft edge, such as 6px, taken from inside the layer's outline; % are of the longer side of the
        layer's picture as it is placed.
    height_factor:
        Factor on the layer's heights in px. Default: its scale, so that slopes stay; 1 where it is stretched.
    clip:
        Show the layer only where something lies below: "yes", "no", or "auto": modes other than "over" are clipped,
        except inside a group.
    """

    name: str = ""
    mode: LayerMode = "over"
    strength: float = 1.0
    at: str | None = None
    anchor: Anchor = "center"
    scale: str = "1"
    rotate: float = 0.0
    flip_h: bool = False
    flip_v: bool = False
    feather: Offset | None = None
    height_factor: float | None = None
    clip: Clip = "auto"

    def __post_init__(self) -> None:
        require_choices(
            ("mode", self.mode, LAYER_MODES), ("anchor", self.anchor, tuple(ANCHORS)), ("clip", self.clip, _CLIPS)
        )
        if isinstance(self.feather, str):  # text is as good as an Offset
            try:
                object.__setattr__(self, "feather", offset(self.feather))
            except UsageError as error:
                raise UsageError(f"--feather {error}") from None
        if not isinstance(self.scale, str):
            object.__setattr__(self, "scale", f"{self.scale:.12g}")
        require_at_least_zero(strength=self.strength)
        if self.mode == "over" and self.strength > 1:
            raise UsageError(f'--strength {self.strength:g}: must lie between 0 and 1 where the mode is "over"')
        if self.feather is not None and self.feather.value < 0:
            raise UsageError(f"--feather {self.feather}: must be zero or more, such as 6px")
        require_number("rotate", self.rotate, -3600, 3600, "30")
        if self.height_factor is not None:
            require_number("height-factor", self.height_factor, -1e3, 1e3, "1")
        _ = self.place, self.factors

    @property
    def place(self) -> tuple[Offset, Offset]:
        """Where the anchor goes, from the canvas's top left corner."""
        if self.at is None:
            across, down = ANCHORS[self.anchor]
            return Offset(100 * across, "%"), Offset(100 * down, "%")
        try:
            across_, down_ = offsets(self.at, (2,), "30%,12mm")
        except UsageError as error:
            raise UsageError(f"--at {error}") from None
        return across_, down_

    @property
    def factors(self) -> tuple[float, float] | Length:
        """Scale across and down, or the width of the layer's picture."""
        return parse_scale(self.scale)


_CLIPS = ("auto", "yes", "no")


@dataclass(frozen=True)
class GroupOptions:
    """How a group of layers, composed among themselves, is blended with what lies below.

    Parameters
    ----------
    name:
        What to call the group.
    mode:
        As for a layer.
    strength:
        As for a layer.
    clip:
        As for a layer.
    """

    name: str = "group"
    mode: LayerMode = "over"
    strength: float = 1.0
    clip: Clip = "auto"

    def __post_init__(self) -> None:
        LayerOptions(self.name, self.mode, self.strength, clip=self.clip)


@dataclass(frozen=True)
class CanvasOptions:
    """The picture that layers are composed on.

    Parameters
    ----------
    size:
        Columns x rows. Default: those of the lowest layer.
    width:
        Width of the whole picture, such as 100mm. Default: what the lowest layer says.
    ground:
        What lies below the lowest layer: "clear" (nothing: it stays transparent) or "flat" (a plate).
    """

    size: str | None = None
    width: Length | None = None
    ground: Ground = "clear"

    def __post_init__(self) -> None:
        require_choices(("ground", self.ground, ("clear", "flat")))
        if isinstance(self.width, str):
            object.__setattr__(self, "width", length(self.width))
        require_absolute(width=self.width)
        _ = self.cols_rows

    @property
    def cols_rows(self) -> tuple[int, int] | None:
        """Columns and rows, where they are given."""
        return None if self.size is None else parse_size("size", self.size)

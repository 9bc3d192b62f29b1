"""How maps are blended, placed and composed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset, offsets
from nmaptool.options.blend_modes import blend_meanings, layer_meanings
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, SignedText, Switch, Text, Weight, parse_size
from nmaptool.options.length_kinds import LengthText, OffsetText, ScaleText, parse_scale
from nmaptool.options.transform import HEIGHT_FACTOR, ROTATION

Anchor = Literal[
    "center", "top-left", "top", "top-right", "left", "right", "bottom-left", "bottom", "bottom-right"
]  # fmt: skip
Clip = Literal["auto", "yes", "no"]
Ground = Literal["clear", "flat"]

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
LAYER_MODE = Choice("over", layer_meanings)


@dataclass(frozen=True)
class BlendOptions(Options, group="Composing"):
    """How a detail map is blended with a base map.

    Parameters
    ----------
    mode:
        How the normals are combined:
    strength:
        How much of the detail: 0 none, 1 all, 2 twice as steep.
    fit:
        Stretch a detail map of another size to the base's.
    """

    mode: str = option("rnm", Choice("rnm", blend_meanings))
    strength: float = option(1.0, Weight("0.8"))
    fit: bool = option(False, Switch())


@dataclass(frozen=True)
class LayerOptions(Options, group="Composing"):
    """Where a layer lies and how it is blended with what lies below.

    Parameters
    ----------
    name:
        What to call the layer. Default: its file.
    mode:
        How the layer is combined with what lies below:
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

    name: str = option("", Text("bunny"))
    mode: str = option("over", LAYER_MODE)
    strength: float = option(1.0, Weight("0.8"))
    at: str | None = option(None, SignedText("30%,50%"))
    anchor: Anchor = option("center", choice_of(Anchor, "bottom"))
    scale: str = option("1", ScaleText())
    rotate: float = option(0.0, ROTATION)
    flip_h: bool = option(False, Switch())
    flip_v: bool = option(False, Switch())
    feather: Offset | None = option(None, OffsetText())
    height_factor: float | None = option(None, HEIGHT_FACTOR)
    clip: Clip = option("auto", choice_of(Clip, "no"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mode == "over" and self.strength > 1:
            raise UsageError(f'`strength={self.strength:g}`: must lie between 0 and 1 where the mode is "over"')
        _ = self.place

    @property
    def place(self) -> tuple[Offset, Offset]:
        """Where the anchor goes, from the canvas's top left corner."""
        if self.at is None:
            across, down = ANCHORS[self.anchor]
            return Offset(100 * across, "%"), Offset(100 * down, "%")
        try:
            across_, down_ = offsets(self.at, (2,), "30%,12mm")
        except UsageError as error:
            raise UsageError(f"`at={self.at!r}`: {str(error).removeprefix(f'{self.at!r}: ')}") from None
        return across_, down_

    @property
    def factors(self) -> tuple[float, float] | Length:
        """Scale across and down, or the width of the layer's picture."""
        return parse_scale(self.scale)


@dataclass(frozen=True)
class GroupOptions(Options, group="Composing"):
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

    name: str = option("group", Text("bunny"))
    mode: str = option("over", LAYER_MODE)
    strength: float = option(1.0, Weight("0.8"))
    clip: Clip = option("auto", choice_of(Clip, "no"))

    def __post_init__(self) -> None:
        super().__post_init__()
        LayerOptions(self.name, self.mode, self.strength, clip=self.clip)


@dataclass(frozen=True)
class CanvasOptions(Options, group="Composing"):
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

    size: str | None = option(None, SignedText("1000x900"))
    width: Length | None = option(None, LengthText("100mm", absolute=True))
    ground: Ground = option("clear", choice_of(Ground, "flat"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.cols_rows

    @property
    def cols_rows(self) -> tuple[int, int] | None:
        """Columns and rows, where they are given."""
        return None if self.size is None else parse_size("size", self.size)

"""Options for blending, placing and composing maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset
from nmaptool.options.blend_modes import blend_meanings, layer_meanings
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, SignedText, Switch, Text, Weight, parse_size
from nmaptool.options.length_kinds import LengthText, OffsetText, ScaleText, parse_distances, parse_scale
from nmaptool.options.transform import HEIGHT_FACTOR, ROTATION

Anchor = Literal[
    "center", "top-left", "top", "top-right", "left", "right", "bottom-left", "bottom", "bottom-right"
]  # fmt: skip
LayerEdge = Literal["blend", "wall"]
Clip = Literal["auto", "yes", "no"]
Ground = Literal["clear", "flat"]

# position of each anchor, as shares of the width and height
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
class BlendOptions(Options, group="Blending"):
    """How a detail map is blended with a base map.

    Parameters
    ----------
    mode:
        How to combine the normals:
    strength:
        How strongly to apply the detail: 0 not at all, 1 unchanged, 2 twice as steep.
    fit:
        Stretch a detail map of another size to the size of the base.
    """

    mode: str = option("rnm", Choice("rnm", blend_meanings))
    strength: float = option(1.0, Weight("0.8"))
    fit: bool = option(False, Switch())


@dataclass(frozen=True)
class LayerOptions(Options, group="Layers"):
    """Where a layer is placed and how it is blended with what is below it.

    Parameters
    ----------
    name:
        Name of the layer. Default: its file name.
    mode:
        How to combine the layer with what is below it:
    strength:
        How strongly to apply the layer: 0 to 1 for "over"; for other modes as in nmap compose blend.
    at:
        Position of the layer's anchor: across,down from the top left corner of the canvas, such as 30%,12mm. % refer
        to the canvas's width and height. Default: the same point of the canvas.
    anchor:
        Point of the layer that goes to --at, and about which it is scaled and rotated: "center", "top-left", "top",
        "top-right", "left", "right", "bottom-left", "bottom" or "bottom-right".
    scale:
        One scale factor, two (across,down), or the new width of the layer's picture, such as 30mm.
    rotate:
        Rotate the layer counter-clockwise by this many degrees.
    flip_h:
        Mirror left to right.
    flip_v:
        Mirror top to bottom.
    feather:
        Width of the soft edge, such as 6px, measured inwards from the layer's silhouette. % refer to the longer side
        of the placed picture.
    height_factor:
        Multiply the layer's heights in px by this factor. Default: the layer's scale, which keeps slopes; 1 if the
        layer is stretched.
    clip:
        Show the layer only where there is something below it: "yes", "no", or "auto", which clips every mode except
        "over", but nothing inside a group.
    edge:
        Outline of the layer in a relief: "blend" runs down into the plate, "wall" stands with vertical walls. --walls
        writes the picture of the walls, for nmap relief --edge wall --wall-mask.
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
    edge: LayerEdge = option("blend", choice_of(LayerEdge, "wall"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mode == "over" and self.strength > 1:
            raise UsageError(f'`strength={self.strength:g}`: must lie between 0 and 1 for the mode "over"')
        _ = self.place

    @property
    def place(self) -> tuple[Offset, Offset]:
        """Position of the anchor, from the canvas's top left corner."""
        if self.at is None:
            across, down = ANCHORS[self.anchor]
            return Offset(100 * across, "%"), Offset(100 * down, "%")
        across_, down_ = parse_distances("at", self.at, (2,), "30%,12mm")
        return across_, down_

    @property
    def factors(self) -> tuple[float, float] | Length:
        """Scale across and down, or the width of the layer's picture."""
        return parse_scale(self.scale)


@dataclass(frozen=True)
class GroupOptions(Options, group="Layers"):
    """How a group of layers, composed with each other first, is blended with what is below it.

    Parameters
    ----------
    name:
        Name of the group.
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
class CanvasOptions(Options, group="Canvas"):
    """The canvas that layers are composed on.

    Parameters
    ----------
    size:
        Size of the canvas, columns x rows in pixels. Default: the size of the lowest layer.
    width:
        Width of the whole picture, such as 100mm. Default: the width stored in the lowest layer.
    ground:
        What is below the lowest layer: "clear" (transparent) or "flat" (a plate).
    """

    size: str | None = option(None, SignedText("1000x900"))
    width: Length | None = option(None, LengthText("100mm", absolute=True))
    ground: Ground = option("clear", choice_of(Ground, "flat"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.cols_rows

    @property
    def cols_rows(self) -> tuple[int, int] | None:
        """Columns and rows; None if not given."""
        return None if self.size is None else parse_size("size", self.size)

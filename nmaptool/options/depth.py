"""How a depth or height picture becomes normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from nmaptool.core.units import Length
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Numeric, Switch, require_number
from nmaptool.options.length_kinds import LengthOr, LengthText

AutoOrNone = Literal["auto", "none"]
DepthBackground = Literal["auto", "flat", "none"]

NARROWEST_FOV, WIDEST_FOV = 0.1, 150.0


@dataclass(frozen=True)
class DepthOptions(Options, group="Composing"):
    """How a depth or height picture becomes normals. White is near and high unless the file says otherwise.

    Parameters
    ----------
    depth_scale:
        How far white stands above black, such as 10%, 40px or 5mm; here % is of the picture's width. Default: what
        the file says, else 10%.
    invert:
        Dark is near. Files that say what they hold, as nmaptool's own do, need no telling.
    fov:
        Degrees that the camera of a perspective depth picture sees across the longer side; the slopes are then
        those of the picture, and integrate to distance * ln(depth). 0 is orthographic. Default: what the file says,
        else 0.
    jump:
        Height of a step from one pixel to the next that is a jump: one part hides another, and no slope is taken
        across. "auto" finds jumps by the slopes beside them, "none" takes every step for a slope; or say how high,
        such as 4px.
    smooth:
        How far the surface may leave the stored heights to be smooth. "auto" measures the steps of the codes and the
        noise, and leaves clean pictures as they are; "none" believes every code; or a height, such as 0.5px.
    background:
        "auto": transparent pixels, those without depth and large flat patches at the bottom are not there, so that only
        the motif is; "flat" keeps those patches as a plate; "none" takes every pixel for surface.
    width:
        Width of the whole picture, such as 100mm. Default: what the file says.
    """

    depth_scale: Length | None = option(None, LengthText("10%"))
    invert: bool = option(False, Switch())
    fov: float | None = option(None, Numeric())
    jump: Length | AutoOrNone = option("auto", LengthOr("2px", get_args(AutoOrNone)))
    smooth: Length | AutoOrNone = option("auto", LengthOr("2px", get_args(AutoOrNone)))
    background: DepthBackground = option("auto", choice_of(DepthBackground))
    width: Length | None = option(None, LengthText("100mm", absolute=True))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fov is not None and self.fov != 0:
            require_number("fov", self.fov, NARROWEST_FOV, WIDEST_FOV, "35 (0 is orthographic)")

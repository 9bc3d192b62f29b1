"""Options for turning a depth or height picture into normals."""

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
class DepthOptions(Options, group="Depth"):
    """How a depth or height picture becomes normals. White is near or high unless the file states otherwise.

    Parameters
    ----------
    depth_scale:
        Height of white above black, such as 10%, 40px or 5mm; % refer to the picture's width. Larger values make the
        surface steeper. Default: the scale stored in the file, otherwise 10%.
    invert:
        Read dark as near. Not needed for files that state it, such as those that nmaptool writes.
    fov:
        Field of view of the camera of a perspective depth picture, in degrees across the longer side; 0 is
        orthographic. With perspective, slopes are measured in the picture and integrate to distance * ln(depth).
        Default: the value stored in the file, otherwise 0.
    jump:
        Smallest step between two pixels that counts as a jump, where one part hides another and no slope is taken: a
        height, such as 4px. "auto" finds jumps from the slopes beside them; "none" treats every step as a slope.
    smooth:
        How far the surface may depart from the stored heights to become smooth: a height, such as 0.5px. "auto"
        measures the quantisation steps and the noise, and leaves clean pictures unchanged; "none" keeps every stored
        height.
    background:
        "auto" removes transparent pixels, pixels without depth and large flat patches at the lowest height, and keeps
        only the motif. "flat" keeps those patches as a plate. "none" treats every pixel as surface.
    width:
        Width of the whole picture, such as 100mm. Default: the width stored in the file.
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

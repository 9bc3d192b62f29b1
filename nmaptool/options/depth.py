"""Options for turning a depth or height picture into normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, NumbersOr, Switch, require_number
from nmaptool.options.length_kinds import DegreesOrFocal, LengthOr, LengthText
from nmaptool.options.presets import DEPTH_PRESETS

AutoOrNone = Literal["auto", "none"]
DepthBackground = Literal["auto", "flat", "none"]
DepthMeaning = Literal["auto", "height", "distance", "disparity"]

NARROWEST_FOV, WIDEST_FOV = 0.1, 150.0


def _writers() -> dict[str, str]:
    """The programs whose depth pictures are known, with a description."""
    described = {name: f"({preset.description})" for name, preset in DEPTH_PRESETS.items()}
    return {"auto": "(recognises only what is unmistakable)", **described}


@dataclass(frozen=True)
class DepthOptions(Options, group="Depth"):
    """How a depth or height picture becomes normals. White is near or high unless the file or an option says otherwise.

    Parameters
    ----------
    from_:
        The program or device that wrote the picture: sets what its values mean, their unit, and which are empty, unless
        those are given.
    values:
        What a stored value grows with: "height" (or nearness), "distance" from the camera, or "disparity", which is 1
        over distance. "auto" reads a layer named Z or Depth, and a picture with Blender's 1e10 for nothing, as
        distance, and anything else as height, unless the file or its writer says otherwise.
    depth_scale:
        Height of white above black, such as 10%, 40px or 5mm; % refer to the picture's width. Larger values make the
        surface steeper. Default: the scale stored in the file or given by the unit, otherwise 10%; where less than a
        tenth of the range is in use, 10% for the values in use.
    unit:
        Length of one stored unit, such as 1m, 1mm or 0.1mm, for pictures that store real distances or heights; for
        disparities, the distance where the value is 1. Needs the field of view of the camera, or the width of the
        picture. Default: the unit of its writer.
    empty:
        Stored values that mean "no depth", such as 0 or 0,-9999. "auto" finds the usual ones, such as 1e10, -9999 and
        the 0 of depth cameras, and the value that the file names; "none" accepts every finite value as a depth.
    invert:
        Read dark as near, like "distance". Not needed for files that state it, such as those that nmaptool
        writes.
    fov:
        Field of view of the camera of a perspective depth picture, in degrees across the longer side, or its focal
        length in px, such as 525px; 0 is orthographic. With perspective, slopes are measured in the picture and
        integrate to distance * ln(depth). Default: the value stored in the file, otherwise 0.
    fill:
        Largest width of a hole in the surface to be filled from its surroundings, such as 8px. "auto" fills the small
        dropouts of depth cameras and elevation models, up to 1.5% of the longer side; "none" fills nothing.
    jump:
        Smallest step between two pixels that counts as a jump, where one part hides another and no slope is taken: a
        height, such as 4px. "auto" finds jumps from the slopes beside them; "none" treats every step as a slope.
    smooth:
        How far the surface may depart from the stored heights to become smooth: a height, such as 0.5px. "auto"
        measures the quantisation steps and the noise, and leaves clean pictures unchanged; "none" keeps every stored
        height.
    background:
        "auto" removes transparent pixels, pixels without depth and large flat patches at the lowest height, and keeps
        only the motif. "flat" keeps those patches as a plate. "none" treats every pixel as surface, except those whose
        value cannot be a depth.
    width:
        Width of the whole picture, such as 100mm or 5000m. Default: the width stored in the file, or for real distances
        in perspective the width at the median distance.
    """

    from_: str = option("auto", Choice("realsense", _writers))
    values: DepthMeaning = option("auto", choice_of(DepthMeaning))
    depth_scale: Length | None = option(None, LengthText("10%"))
    unit: Length | None = option(None, LengthText("1mm", absolute=True, sets="the length of a stored unit"))
    empty: str = option("auto", NumbersOr("0,-9999", get_args(AutoOrNone)))
    invert: bool = option(False, Switch())
    fov: float | Length | None = option(None, DegreesOrFocal("35"))
    fill: Length | AutoOrNone = option("auto", LengthOr("8px", get_args(AutoOrNone)))
    jump: Length | AutoOrNone = option("auto", LengthOr("2px", get_args(AutoOrNone)))
    smooth: Length | AutoOrNone = option("auto", LengthOr("2px", get_args(AutoOrNone)))
    background: DepthBackground = option("auto", choice_of(DepthBackground))
    width: Length | None = option(None, LengthText("100mm", absolute=True))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fov is not None and not isinstance(self.fov, Length) and self.fov != 0:
            require_number("fov", self.fov, NARROWEST_FOV, WIDEST_FOV, "35 (0 is orthographic)")
        if self.invert and self.values in ("height", "disparity"):
            raise UsageError(
                f"`invert` and `values={self.values!r}`: contradict each other, because `invert` reads small values as "
                "near; give one of them"
            )
        if self.unit is not None and self.depth_scale is not None:
            raise UsageError("`depth_scale` and `unit`: both set the height of the stored values; give one of them")

    @property
    def empty_values(self) -> tuple[float, ...]:
        """The values given by ``empty``; none if they are to be found."""
        return () if self.empty in get_args(AutoOrNone) else tuple(float(part) for part in self.empty.split(","))

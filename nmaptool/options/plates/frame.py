"""Options for the frame along the edge of a plate."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import NameOrFile
from nmaptool.options.length_kinds import LengthText

# the profiles that are made here
FRAME_PROFILES = {
    "flat": "level, with a slope on the inner side, as the rim of a coin",
    "round": "half round",
    "bevel": "rises from the inside to the edge of the plate",
    "rope": "a twisted rope",
    "bead": "a row of beads",
}
PROFILE = NameOrFile("ogee.svg", FRAME_PROFILES)


@dataclass(frozen=True)
class FrameOptions(Options, group="Frame"):
    """The frame along the edge of a plate.

    Parameters
    ----------
    frame:
        Width of a frame along the edge of the plate, such as 3mm. Default: no frame.
    frame_height:
        Height of the frame above the plate, such as 2mm. Default: the height of the motif.
    frame_profile:
        Cross section of the frame, or an SVG file with one open path from the edge of the plate (left) to the inner
        side (right), which is stretched to the width and height of the frame.
    """

    frame: Length | None = option(None, LengthText("3mm"))
    frame_height: Length | None = option(None, LengthText("2mm"))
    frame_profile: str = option("flat", PROFILE)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.frame is None and self.frame_height is not None:
            raise UsageError(f"`frame_height='{self.frame_height}'`: needs `frame`, such as `frame='3mm'`")
        if self.frame is None and self.frame_profile != "flat":
            raise UsageError(f"`frame_profile={self.frame_profile!r}`: needs `frame`, such as `frame='3mm'`")

    @property
    def is_drawn(self) -> bool:
        """Whether the profile is an SVG file."""
        return PROFILE.is_file(self.frame_profile)

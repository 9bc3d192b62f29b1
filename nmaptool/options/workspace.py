"""Options for packing a workspace."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Kind, Switch


@dataclass(frozen=True)
class PackOptions(Options, group="Outputs"):
    """How normal maps become the layers of a workspace.

    Parameters
    ----------
    bits:
        Bits per channel: 8 or 16 for PSD, ORA and TIFF, 32 (floats) for EXR. Default: the most that the format holds.
    half:
        Write EXR in half precision.
    """

    bits: int | None = option(None, Kind("16"))
    half: bool = option(False, Switch())

    def __post_init__(self) -> None:
        if self.bits not in (None, 8, 16, 32):
            raise UsageError(f"`bits={self.bits!r}`: use 8 or 16, or 32 for the floats of EXR")
        if self.half and self.bits not in (None, 32):
            raise UsageError("`half`: applies to EXR only, which holds floats; leave `bits` out")

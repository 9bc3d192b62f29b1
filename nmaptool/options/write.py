"""Options for writing normal maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.options.fields import Options, choice_of, option

Bits = Literal["auto", "8", "16", "half", "float"]
WrittenGreen = Literal["up", "down"]
WrittenZeroCode = Literal["auto", "127", "127.5", "128"]
HeightsAt = Literal["centers", "corners"]


@dataclass(frozen=True)
class WriteOptions(Options, group="Outputs"):
    """How a normal map file is written.

    Parameters
    ----------
    bits:
        "8" or "16" bits per channel in PNG and TIFF, "half" in EXR, "float" in EXR and TIFF. "auto" is 16 bit in PNG
        and TIFF, float in EXR.
    write_green:
        Direction of the green channel in the file: "up" (+Y, OpenGL) or "down" (DirectX).
    write_zero_code:
        The 8-bit code to write for zero: "127.5" (the middle), "128" or "127". Programs that read this code as zero
        then see flat areas as exactly flat. "auto" is the middle; nmap compose convert keeps the code of its input.
    """

    bits: Bits = option("auto", choice_of(Bits))
    write_green: WrittenGreen = option("up", choice_of(WrittenGreen))
    write_zero_code: WrittenZeroCode = option("auto", choice_of(WrittenZeroCode))

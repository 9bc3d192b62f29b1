"""How normal maps are written."""

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
        "8" or "16" bit codes in PNG and TIFF, "half" in EXR, "float" in EXR and TIFF; "auto" is 16 bit in PNG and
        TIFF, float in EXR.
    write_green:
        Which way green points in the file: "up" (+Y, OpenGL) or "down" (DirectX).
    write_zero_code:
        The 8-bit code that stands for zero: "127.5" (the middle), "128" or "127". What is flat is then exactly flat for
        programs that take that code for zero. "auto" is the middle; in nmap compose convert, what the file had.
    """

    bits: Bits = option("auto", choice_of(Bits))
    write_green: WrittenGreen = option("up", choice_of(WrittenGreen))
    write_zero_code: WrittenZeroCode = option("auto", choice_of(WrittenZeroCode))

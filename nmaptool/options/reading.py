"""Options for reading files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Positive, SignedText, Text

Green = Literal["auto", "up", "down"]
ZeroCode = Literal["auto", "127", "127.5", "128"]
Encoding = Literal["auto", "signed", "unsigned"]
Components = Literal["auto", "xyz", "xy", "octahedral"]

_BACKGROUND_WORDS = ("auto", "none", "alpha", "white", "grey", "black", "flat")


def _is_hex_color(text: str) -> bool:
    return len(text) == 7 and text[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in text[1:])


@dataclass(frozen=True)
class ReadOptions(Options, group="Reading"):
    """How a normal map file is read.

    Parameters
    ----------
    layer:
        Read this layer of an EXR that holds several, such as "detail". FILE.exr:detail does the same.
    green:
        Direction of the green channel: "up" (+Y, OpenGL), "down" (DirectX), or "auto": as stated in the file, otherwise
        "down" if the picture proves it, otherwise "up".
    swizzle:
        Channels to use as x, y and z, each with an optional minus sign: "-g,r,b" reads nx = -G, ny = R, nz = B.
    zero_code:
        The 8-bit code that means zero: "127.5" (the middle), "128", "127" (if the values were truncated when the file
        was written), or "auto".
    encoding:
        How a floating-point file stores normals: "signed" (-1 to 1), "unsigned" (0 to 1), or "auto".
    components:
        What each pixel stores. "xyz": red, green and blue. "xy": red and green only; z is computed and blue is ignored,
        for two-channel and BC5 maps and where blue is unreliable (if x and y alone are longer than 1, the normal
        becomes a vertical wall). "octahedral": two octahedral codes in red and green. "auto": "xy" if the file has two
        channels or a constant blue that cannot be z, otherwise "xyz".
    background_color:
        What the background looks like: "auto", "none" (every pixel is surface), "alpha", "white",
        "grey", "black", "flat", or a colour such as "#7f7fff".
    max_megapixels:
        Refuse larger pictures before any memory is used.
    """

    layer: str | None = option(None, Text("detail"))
    green: Green = option("auto", choice_of(Green, "down"))
    swizzle: str | None = option(None, SignedText("-g,r,b"))
    zero_code: ZeroCode = option("auto", choice_of(ZeroCode, "128"))
    encoding: Encoding = option("auto", choice_of(Encoding, "signed"))
    components: Components = option("auto", choice_of(Components, "xy"))
    background_color: str = option("auto", Text("white"))
    max_megapixels: float = option(270.0, Positive())

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.background_color not in _BACKGROUND_WORDS and not _is_hex_color(self.background_color):
            raise UsageError(
                f"`background_color={self.background_color!r}`: use one of {', '.join(_BACKGROUND_WORDS)}, "
                "or a colour such as #7f7fff"
            )

"""Options for reading files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, Positive, SignedText, Switch, Text
from nmaptool.options.presets import NORMAL_PRESETS

Green = Literal["auto", "up", "down"]
ZeroCode = Literal["auto", "127", "127.5", "128"]
Encoding = Literal["auto", "signed", "unsigned"]
Components = Literal["auto", "xyz", "xy", "octahedral"]
Curve = Literal["none", "srgb", "linear", "video"]

_BACKGROUND_WORDS = ("auto", "none", "alpha", "white", "grey", "black", "flat")


def _preset_names() -> tuple[str, ...]:
    return ("auto", *NORMAL_PRESETS)


def _is_hex_color(text: str) -> bool:
    return len(text) == 7 and text[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in text[1:])


@dataclass(frozen=True)
class ReadOptions(Options, group="Reading"):
    """How a normal map file is read.

    Parameters
    ----------
    layer:
        Layer of an EXR, page of a TIFF or array of an .npz to read, such as "detail". FILE.exr:detail does the same.
    from_:
        Program that wrote the map: sets the channels, green, the zero code and the components as that program writes
        them, unless they are given. nmap inspect --presets lists the programs. "auto" recognises only what is
        unmistakable, such as x in alpha.
    green:
        Direction of the green channel: "up" (+Y, OpenGL), "down" (DirectX), or "auto": as stated in the file, otherwise
        "down" if the picture proves it, otherwise "up".
    swizzle:
        Channels to use as x, y and z, each with an optional minus sign: "-g,r,b" reads nx = -G, ny = R, nz = B. With
        a, alpha is a channel: "a,g,b" with components "xy" reads x from alpha.
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
    curve:
        Curve to undo before the values are read: "srgb" if the map was gamma-encoded like a photograph, "linear" if it
        was decoded like one, "video" for codes from 16 to 235.
    background_color:
        What the background looks like: "auto", "none" (every pixel is surface), "alpha", "white",
        "grey", "black", "flat", or a colour such as "#7f7fff".
    max_megapixels:
        Refuse larger pictures before any memory is used.
    force:
        Go on with a map of which more than half faces away from the viewer.
    """

    layer: str | None = option(None, Text("detail"))
    from_: str = option("auto", Choice("dsine", _preset_names))
    green: Green = option("auto", choice_of(Green, "down"))
    swizzle: str | None = option(None, SignedText("-g,r,b"))
    zero_code: ZeroCode = option("auto", choice_of(ZeroCode, "128"))
    encoding: Encoding = option("auto", choice_of(Encoding, "signed"))
    components: Components = option("auto", choice_of(Components, "xy"))
    curve: Curve = option("none", choice_of(Curve, "srgb"))
    background_color: str = option("auto", Text("white"))
    max_megapixels: float = option(270.0, Positive())
    force: bool = option(False, Switch())

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.background_color not in _BACKGROUND_WORDS and not _is_hex_color(self.background_color):
            raise UsageError(
                f"`background_color={self.background_color!r}`: use one of {', '.join(_BACKGROUND_WORDS)}, "
                "or a colour such as #7f7fff"
            )
        if self.curve != "none" and self.encoding == "signed":
            raise UsageError(
                f"`curve={self.curve!r}`: applies to values from 0 to 1; leave out `encoding='signed'` or the curve"
            )

    def as_written_by(self, name: str) -> ReadOptions:
        """The options with the values of a preset where they are not given.

        Parameters
        ----------
        name : str
            A key of `nmaptool.options.presets.NORMAL_PRESETS`.
        """
        preset = NORMAL_PRESETS[name]
        stated = {key: getattr(preset, key) for key in ("zero_code", "components") if getattr(self, key) == "auto"}
        # a given order of channels sets the sign of y, too
        if self.swizzle is None:
            stated["swizzle"] = preset.swizzle
            stated |= {"green": preset.green} if self.green == "auto" else {}
        return replace(self, **stated)

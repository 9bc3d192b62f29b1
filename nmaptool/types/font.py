"""A font, as the bytes of its file."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.types.shown import OneLine


@dataclass(frozen=True, eq=False, repr=False)
class Font(OneLine):
    """A font; `nmaptool.read_font` reads one.

    Parameters
    ----------
    data : bytes
        The font file.
    name : str
        Name for messages, such as "DejaVu Serif:bold (DejaVuSerif-Bold.ttf)".
    face : int
        Number of the font in a collection (.ttc), from 0.
    """

    data: bytes
    name: str
    face: int = 0

    def _line(self) -> str:
        return f"{self.name}, {len(self.data)} bytes"

"""Options for lettering on a plate."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Number, SignedText, Switch, Text
from nmaptool.options.length_kinds import LengthText, parse_distances

TextPath = Literal["line", "arc", "circle", "ring"]
TextSide = Literal["top", "bottom"]


_FONT_FILE = re.compile(r".*\.(ttf|otf|ttc|otc|woff2?)(#\d+)?", re.IGNORECASE)


def is_font_file(font: str) -> bool:
    """Whether a font is named by its file.

    >>> is_font_file("fonts/title.ttf"), is_font_file("DejaVu Serif:bold")
    (True, False)
    """
    return _FONT_FILE.fullmatch(font) is not None


@dataclass(frozen=True)
class TextOptions(Options, group="Text"):
    """Lettering on a plate.

    Parameters
    ----------
    text:
        Text to put on the plate. With --text-path line, a backslash and n begin a new line. Scripts that run from right
        to left are ordered as Unicode requires.
    text_path:
        "line": straight, at --text-at. "arc": along the edge of the plate, centred at --text-side. "circle": the same,
        spread evenly over the whole edge. "ring": repeated around the whole edge as often as it fits.
    text_side:
        Where a text along the edge is centred. At the "top" the heads of the letters point outwards, at the "bottom"
        inwards, so both can be read.
    text_size:
        Height of the capitals, such as 2mm. Default: 7% of the plate's longer side.
    text_height:
        How high the letters stand, or how deep they lie, such as 0.4mm. Default: half the height of the relief, at most
        a fifth of their size.
    text_sunk:
        Cut the letters into the plate instead of raising them.
    text_at:
        Middle of a straight text: across,down from the upper left corner of the plate. Default: below the motif of a
        rect plate, which makes room for it; 50%,85% of others.
    text_inset:
        Distance of letters on the edge from the frame, or from the edge of a plate without one. Default: 0.6 of their
        size.
    text_spacing:
        Length of the text as a factor of the font's own, such as 1.1; the difference is shared evenly by the gaps
        between letters.
    text_rotate:
        Degrees counter-clockwise, for a straight text.
    font:
        Font file (.ttf, .otf, .ttc), or the name of an installed font with a weight, "italic" or "condensed", such as
        "DejaVu Serif:bold".
    """

    text: str | None = option(None, Text("ANNO MMXXVI"))
    text_path: TextPath = option("line", choice_of(TextPath, "arc"))
    text_side: TextSide = option("top", choice_of(TextSide, "bottom"))
    text_size: Length | None = option(None, LengthText("2mm"))
    text_height: Length | None = option(None, LengthText("0.4mm"))
    text_sunk: bool = option(False, Switch())
    text_at: str | None = option(None, SignedText("50%,85%"))
    text_inset: Length | None = option(None, LengthText("1mm"))
    text_spacing: float = option(1.0, Number("1.1", 0.5, 5.0))
    text_rotate: float = option(0.0, Number("90", -360.0, 360.0))
    font: str = option("DejaVu Serif:bold", Text("DejaVu Serif:bold"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.text is not None and not self.wording:
            raise UsageError(f"`text={self.text!r}`: is empty; give at least one letter")
        if self.text_path != "line" and len(self.wording.splitlines()) > 1:
            raise UsageError(f"`text={self.text!r}`: only a straight text has several lines, `text_path='line'`")
        if self.text_at is not None and self.text_path != "line":
            raise UsageError(f"`text_at='{self.text_at}'`: is for a straight text, `text_path='line'`")
        if self.text_rotate and self.text_path != "line":
            raise UsageError(f"`text_rotate={self.text_rotate:g}`: is for a straight text, `text_path='line'`")
        if self.text_inset is not None and self.text_path == "line":
            raise UsageError(
                f"`text_inset='{self.text_inset}'`: is for a text along the edge, such as `text_path='arc'`"
            )
        if self.text_at is not None:
            parse_distances("text_at", self.text_at, (2,), "50%,85%")

    @property
    def wording(self) -> str:
        r"""The text with its line breaks, which a command line may write as \n."""
        return (self.text or "").replace("\\n", "\n").strip()

    @property
    def middle(self) -> tuple[Offset, Offset]:
        """Where the middle of a straight text lies: across and down."""
        across, down = parse_distances("text_at", self.text_at or "50%,85%", (2,), "50%,85%")
        return across, down

"""A font opened for shaping: its measures, the outlines of its glyphs, and the script of characters."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.curves import flatten_bezier
from nmaptool.core.errors import InputError
from nmaptool.types.font import Font

# an outline: for each closed contour its pieces, (2, 2) lines, (3, 2) quadratic or (4, 2) cubic curves
Outline = tuple[tuple[Float64, ...], ...]


@dataclass
class _Pen:
    """Collects the pieces that HarfBuzz draws."""

    contours: list[list[Float64]] = field(default_factory=list)
    at: tuple[float, float] = (0.0, 0.0)
    start: tuple[float, float] = (0.0, 0.0)

    def begin(self, x: float, y: float) -> None:
        self.contours.append([])
        self.at = self.start = (x, y)

    def draw(self, *points: float) -> None:
        to = [(points[i], points[i + 1]) for i in range(0, len(points), 2)]
        self.contours[-1].append(np.array([self.at, *to], np.float64))
        self.at = to[-1]

    def close(self) -> None:
        if self.at != self.start:
            self.draw(*self.start)


class Face:
    """A font opened with HarfBuzz; lengths are in font units.

    Parameters
    ----------
    font : Font

    Raises
    ------
    InputError
        If the font has no capitals whose height is known.
    """

    def __init__(self, font: Font) -> None:
        import uharfbuzz

        self.name = font.name
        self.face = uharfbuzz.Face(font.data, font.face)
        self.hb_font = uharfbuzz.Font(self.face)
        self._outlines: dict[int, Outline] = {}
        self._draw_funcs = _draw_funcs()
        extents = self.hb_font.get_font_extents("ltr")
        self.line_height = float(extents.ascender - extents.descender + extents.line_gap)
        self.cap_height = self._cap_height()

    def _cap_height(self) -> float:
        """Height of the capitals: as the font states it, else of the outline of H, else of the ascender."""
        data = self.face.reference_table("OS/2").data
        if len(data) >= 90 and int.from_bytes(data[:2], "big") >= 2:
            stated = int.from_bytes(data[88:90], "big", signed=True)
            if stated > 0:
                return float(stated)
        glyph = self.hb_font.get_nominal_glyph(ord("H"))
        outline = self.outline(glyph) if glyph else ()
        top = max((piece[:, 1].max() for contour in outline for piece in contour), default=0.0)
        top = top if top > 0 else self.hb_font.get_font_extents("ltr").ascender
        if top <= 0:
            raise InputError(f"font {self.name}: does not say how high its letters are; use another `font`")
        return float(top)

    def outline(self, glyph: int) -> Outline:
        """The closed contours of a glyph."""
        if glyph not in self._outlines:
            pen = _Pen()
            self.hb_font.draw_glyph(glyph, self._draw_funcs, pen)
            self._outlines[glyph] = tuple(tuple(contour) for contour in pen.contours if contour)
        return self._outlines[glyph]

    def rings(self, glyph: int, scale: float, tolerance: float) -> list[Float64]:
        """The contours of a glyph, scaled and as polygons within a tolerance; they may cross each other."""
        made = []
        for contour in self.outline(glyph):
            ring = np.concatenate([flatten_bezier(piece * scale, tolerance) for piece in contour])
            if len(ring) > 2:
                made.append(ring)
        return made


@lru_cache(1)
def _draw_funcs() -> Any:
    import uharfbuzz

    made = uharfbuzz.DrawFuncs()
    made.set_move_to_func(lambda x, y, pen: pen.begin(x, y))
    made.set_line_to_func(lambda x, y, pen: pen.draw(x, y))
    made.set_quadratic_to_func(lambda cx, cy, x, y, pen: pen.draw(cx, cy, x, y))
    made.set_cubic_to_func(lambda ax, ay, bx, by, x, y, pen: pen.draw(ax, ay, bx, by, x, y))
    made.set_close_path_func(lambda pen: pen.close())
    return made


@lru_cache(8)
def open_face(font: Font) -> Face:
    """Open a font; the last ones stay open."""
    return Face(font)


@lru_cache(4096)
def script_of(letter: str) -> str | None:
    """The ISO 15924 script of a character, such as "Latn"; None if several scripts share it.

    >>> script_of("A"), script_of("ש"), script_of("1")
    ('Latn', 'Hebr', None)
    """
    import uharfbuzz

    buffer = uharfbuzz.Buffer()
    buffer.add_str(letter)
    buffer.guess_segment_properties()
    return str(buffer.script) if buffer.script else None

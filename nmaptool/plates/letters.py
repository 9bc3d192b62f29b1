"""The lettering of a plate: where it lies, and its heights."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.lettering.place import around, straight
from nmaptool.lettering.shaping import lay_out, lay_out_lines
from nmaptool.lettering.strokes import thinnest_stroke_mm
from nmaptool.options.plates import TextOptions
from nmaptool.plates.board import Board
from nmaptool.plates.distance import Curves, inside_points
from nmaptool.plates.frame import slope_width
from nmaptool.plates.layout import Layout
from nmaptool.plates.polygons import offset, outer_rings
from nmaptool.plates.profiles import slope
from nmaptool.types.contours import Contours, ring_area
from nmaptool.types.plate import PlateDesign

# height of letters: share of the relief's, and of their size at most
_OF_RELIEF = 0.5
_OF_SIZE = 0.2
# the curve of a text turns corners of the plate with this radius, by the size of the letters
_TURN = 1.5


@dataclass(frozen=True, eq=False)
class Letters:
    """A text on a plate.

    Attributes
    ----------
    options : TextOptions
    contours : Contours
        In mm from the lower left corner of the picture.
    size_mm : float
        Height of the capitals.
    length_mm : float
        Of the text.
    stroke_mm : float
        Width of its thinnest strokes.
    given_mm : float or None
        Height of the letters, if it is given.
    """

    options: TextOptions
    contours: Contours
    size_mm: float
    length_mm: float
    stroke_mm: float
    given_mm: float | None

    @property
    def name(self) -> str:
        """The text in quotes, for messages."""
        return named(self.options)

    def height_mm(self, relief_mm: float) -> float:
        """Height of the letters above the plate, negative if they are sunk."""
        height = self.given_mm
        if height is None:
            height = min(_OF_RELIEF * relief_mm or np.inf, _OF_SIZE * self.size_mm)
        return -height if self.options.text_sunk else height

    def moved(self, x_mm: float, y_mm: float) -> Letters:
        """The same letters elsewhere."""
        return dataclasses.replace(self, contours=self.contours.moved(x_mm, y_mm))

    def facts(self, relief_mm: float) -> dict[str, Any]:
        """For the report, on a relief of some height."""
        return {
            "text": self.options.text,
            "path": self.options.text_path,
            "size_mm": self.size_mm,
            "height_mm": self.height_mm(relief_mm),
            "length_mm": self.length_mm,
            "stroke_mm": self.stroke_mm,
            "area_mm2": self.contours.area_mm2,
        }


def named(text: TextOptions) -> str:
    """A text in quotes on one line, for messages."""
    return repr(" ".join(text.wording.split()))


def letters_of(layout: Layout, outline: Contours, design: PlateDesign) -> tuple[Letters, ...]:
    """The texts of a design on its plate.

    Parameters
    ----------
    layout : Layout
    outline : Contours
        Of the plate without openings, in mm from the lower left corner of the picture.
    design : PlateDesign

    Raises
    ------
    InputError
        If a text does not fit inside the frame, or its font lacks a character.
    """
    return tuple(_placed(text, layout, outline, design) for text in design.texts)


def _placed(text: TextOptions, layout: Layout, outline: Contours, design: PlateDesign) -> Letters:
    if text.text is None:
        raise UsageError("`text`: a text needs letters, such as `text='ANNO MMXXVI'`")
    if text.font not in design.fonts:
        raise UsageError(f"`font={text.font!r}`: the design lacks this font; read it with read_design")
    font, size = design.fonts[text.font], layout.sizes.text(text)
    if text.text_path == "line":
        lines = lay_out_lines(font, text.wording, size, text.text_spacing)
        left, top = layout.middle_mm + np.array([-layout.width_mm, layout.height_mm]) / 2
        across, down = text.middle
        x = left + layout.sizes.along_mm(across, layout.width_mm)
        y = top - layout.sizes.along_mm(down, layout.height_mm)
        if text.text_at is None and layout.sizes.strip(design) and not layout.is_cover:
            below = layout.sizes.margin(design) + layout.sizes.strip(design)
            y = top - layout.height_mm + layout.sizes.frame(design) + below / 2
        contours = straight(lines, text.text_rotate).moved(float(x), float(y))
        length = max(line.advance_mm for line in lines if line is not None)
    else:
        line = lay_out(font, text.wording, size, text.text_spacing)
        ring = _text_ring(text, layout, outline, design)
        contours, length = around(line, ring, text.text_path, text.text_side), line.advance_mm
    _check_inside(text, contours, outline, layout.sizes.frame(design), size)
    given = None if text.text_height is None else layout.sizes.mm(text.text_height)
    return Letters(text, contours, size, length, thinnest_stroke_mm(contours), given)


def _text_ring(text: TextOptions, layout: Layout, outline: Contours, design: PlateDesign) -> Float64:
    """The inner edge of the band of letters of a text along the edge."""
    sizes = layout.sizes
    size = sizes.text(text)
    inset = sizes.frame(design) + sizes.text_inset(text) + size
    turn = _TURN * size
    found = outer_rings(offset(offset(outline, -inset - turn), turn))
    if not found.rings:
        found = outer_rings(offset(outline, -inset))
    if not found.rings:
        raise InputError(
            f"the text {named(text)} lies {inset:.4g} mm inside the edge of a plate {layout.width_mm:.4g} mm wide; use "
            "a smaller `text_size`"
        )
    return max(found.rings, key=ring_area)


def _check_inside(text: TextOptions, contours: Contours, outline: Contours, frame_mm: float, size: float) -> None:
    """Refuse letters outside the frame."""
    points = np.concatenate(contours.rings)
    depth = Curves(outline, size / 4).nearest(points).distance_mm
    depth = np.where(inside_points(outline, points), depth, -depth)
    least = float(depth.min())
    if least < frame_mm - 1e-6:
        width, height = contours.bounds_mm[1] - contours.bounds_mm[0]
        where = "into the frame" if least >= 0 and frame_mm else "beyond the edge of the plate"
        beyond = frame_mm - least if least >= 0 else -least
        raise InputError(
            f"the text {named(text)} is {width:.4g} x {height:.4g} mm and reaches {beyond:.3g} mm {where}; use a "
            "smaller `text_size`, a shorter text or another place"
        )


def letter_heights(board: Board, letters: Letters, height_mm: float, draft: float) -> Float64:
    """(rows, cols) float64 mm that the letters add at the vertices of a board.

    Half the height lies on the outline of the letters, so their area at half height is that of the font's outlines.
    Where the draft would need wider strokes, the slopes are steeper, so that thin strokes reach the full height.
    """
    contours = board.placed(letters.contours)
    widest = max(letters.stroke_mm - 2 * board.pitch_mm, board.pitch_mm)  # slopes are averaged over two pixels
    wide = min(slope_width(abs(height_mm), draft, board.pitch_mm), widest)
    reach = wide / 2 + 2 * board.pitch_mm
    return slope(board.depth_mm(contours, reach), wide, board.pitch_mm) * height_mm

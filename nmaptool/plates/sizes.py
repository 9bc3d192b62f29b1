"""Lengths of a design in mm, once the size of the plate is known."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.units import Length, Offset
from nmaptool.options.plates import TextOptions
from nmaptool.types.plate import PlateDesign

_MARGIN = Length(4.0, "%")
_MARGIN_BESIDE_TEXT = Length(1.5, "%")
_TEXT_SIZE = Length(7.0, "%")
# distances of lettering along the edge, as shares of its size
_TEXT_INSET = 0.6
_TEXT_GAP = 0.5
# distance of the lines of a straight text, and the space around it, by its size
_LINE = 1.6
_STRIP = 0.8


@dataclass(frozen=True)
class Sizes:
    """Lengths in mm; % are per cent of the longer side of the plate.

    Attributes
    ----------
    longer_side_mm : float
        Of the plate.
    pitch_mm : float
        Size of a pixel of the map.
    """

    longer_side_mm: float
    pitch_mm: float

    def mm(self, length: Length) -> float:
        """A length in mm."""
        if length.unit == "%":
            return length.value / 100 * self.longer_side_mm
        return length.to_mm(self.pitch_mm, 1)

    def along_mm(self, distance: Offset, side_mm: float) -> float:
        """A distance along a side of the plate in mm."""
        if distance.unit == "%":
            return distance.value / 100 * side_mm
        return distance.to_px(self.pitch_mm, 1) * self.pitch_mm

    def frame(self, design: PlateDesign) -> float:
        """Width of the frame; 0 without one."""
        return 0.0 if design.frame.frame is None else self.mm(design.frame.frame)

    def margin(self, design: PlateDesign) -> float:
        """Space around the motif."""
        own = _MARGIN_BESIDE_TEXT if any(text.text_path != "line" for text in design.texts) else _MARGIN
        return self.mm(design.plate.margin or own)

    def text(self, text: TextOptions) -> float:
        """Height of the capitals."""
        return self.mm(text.text_size or _TEXT_SIZE)

    def text_inset(self, text: TextOptions) -> float:
        """Distance of a text along the edge from the frame."""
        return self.text(text) * _TEXT_INSET if text.text_inset is None else self.mm(text.text_inset)

    def band(self, design: PlateDesign) -> float:
        """Width of the band inside the frame that the lettering along the edge takes; 0 without any."""
        edge = [text for text in design.texts if text.text_path != "line"]
        return max((self.text_inset(text) + self.text(text) * (1 + _TEXT_GAP) for text in edge), default=0.0)

    def inset(self, design: PlateDesign, *, is_cover: bool = False) -> float:
        """Distance of the motif from the edge; of the field that the picture covers with ``is_cover``."""
        return self.frame(design) + self.band(design) + (0.0 if is_cover else self.margin(design))

    def strip(self, design: PlateDesign) -> float:
        """Height of the strip below the motif of a rect plate that a straight text without a place takes."""
        found = [text for text in design.texts if text.text_path == "line" and text.text_at is None]
        if design.plate.shape != "rect" or not found:
            return 0.0
        lines = [1 + _LINE * (len(text.wording.splitlines()) - 1) for text in found]
        return max(self.text(text) * (count + _STRIP) for text, count in zip(found, lines, strict=True))

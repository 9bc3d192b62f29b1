"""Parts of a relief: rectangles of its pixels."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PlannedPart:
    """Where a part of a relief lies.

    Neighbours share the vertices of the grid along the line between them.

    Attributes
    ----------
    row, col : int
        From 0 at the upper left.
    top, bottom, left, right : int
        Pixels of the whole: the first row, one more than the last, the same of the columns.
    """

    row: int
    col: int
    top: int
    bottom: int
    left: int
    right: int

    @property
    def rows(self) -> slice:
        """Its rows of pixels."""
        return slice(self.top, self.bottom)

    @property
    def cols(self) -> slice:
        """Its columns of pixels."""
        return slice(self.left, self.right)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of pixels."""
        return self.bottom - self.top, self.right - self.left

    def size_mm(self, pitch_mm: float) -> tuple[float, float]:
        """Width and height."""
        return (self.right - self.left) * pitch_mm, (self.bottom - self.top) * pitch_mm

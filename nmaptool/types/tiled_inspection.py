"""Measurements of a normal map larger than memory."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.types.inspection import Finding, Inspection
from nmaptool.types.report import Report
from nmaptool.types.shown import counted


@dataclass(frozen=True, eq=False, repr=False)
class TiledInspection(Report):
    """Everything that is measured of a large map.

    Attributes
    ----------
    inspection : Inspection
        As for a map in memory, over the tiles that can be read.
    chunk : (int, int)
        Rows and columns that the store reads at once.
    tile, tiles : int
        Side of a tile in px, and their number.
    unreadable : int
        Tiles that cannot be read or decoded: chunks are missing or damaged, or hold NaN where the map is defined.
    problems : tuple of str
        What is wrong with the first of them.
    findings : tuple of Finding
        Those of the inspection, and one about the tiles that cannot be read.
    """

    inspection: Inspection
    chunk: tuple[int, int]
    tile: int
    tiles: int
    unreadable: int = 0
    problems: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()

    def _line(self) -> str:
        return f"{self.inspection._line()}, {counted(self.unreadable, 'unreadable tile')} of {self.tiles}"

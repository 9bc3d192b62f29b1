"""An edit of a map larger than memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from nmaptool.types.normal_map import Decoding
from nmaptool.types.report import Report

_Report = TypeVar("_Report", bound=Report)


@dataclass(frozen=True)
class TiledInput:
    """An input of an edit by tiles, and how it was read.

    Attributes
    ----------
    name : str
    rows, cols : int
    decoding : Decoding
    """

    name: str
    rows: int
    cols: int
    decoding: Decoding


@dataclass(frozen=True, eq=False, repr=False)
class TiledEdit(Report, Generic[_Report]):
    """How a large map was edited by tiles.

    Attributes
    ----------
    report : ComposeReport, LayerReport or DepthReport
        As for a map in memory. Its means of |curl| leave out the borders between tiles.
    output : str
        The store that was written.
    rows, cols : int
    pitch_mm : float or None
    tile, overlap : int
        Side of a tile, and how far around it its pixels depend on others, in px.
    tiles, workers : int
        Number of tiles, and of worker processes: 0 if this process did the work.
    resumed : int
        Steps of tiles that an earlier run had finished.
    inputs : tuple of TiledInput
    touched : int or None
        Tiles that layers touch; the others are copied. None if every tile is worked on.
    """

    report: _Report
    output: str
    rows: int
    cols: int
    pitch_mm: float | None
    tile: int
    overlap: int
    tiles: int
    workers: int
    resumed: int = 0
    inputs: tuple[TiledInput, ...] = ()
    touched: int | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {**super().to_dict(), "report": self.report.to_dict()}

    def _line(self) -> str:
        return f"{self.output}: {self.cols} x {self.rows} px in {self.tiles} tiles of {self.tile} px"

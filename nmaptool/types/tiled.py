"""A relief of a map larger than memory."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.types.relief import ReliefReport
from nmaptool.types.report import Report


@dataclass(frozen=True, eq=False, repr=False)
class TiledReport(Report):
    """How a relief was solved by tiles.

    Attributes
    ----------
    relief : ReliefReport
        As for a relief in memory; ``iterations`` sums the largest number of each sweep, ``history`` has one residual
        for each.
    output : str
        The store of the heights.
    rows, cols : int
    tile, overlap, factor : int
        Side of a tile, how far its window reaches into its neighbours, and side of a coarse face, in px.
    tiles, workers, sweeps : int
    resumed : int
        Steps of tiles that an earlier run had finished.
    warnings : tuple of str
        Doubts about the inputs.
    """

    relief: ReliefReport
    output: str
    rows: int
    cols: int
    tile: int
    overlap: int
    factor: int
    tiles: int
    workers: int
    sweeps: int
    resumed: int = 0
    warnings: tuple[str, ...] = ()

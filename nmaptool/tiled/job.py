"""What every task of a relief by tiles knows: small values, sent to each worker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from nmaptool.io.stores.grey import GreyStore
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import ReadOptions, ReliefFiles, ReliefOptions
from nmaptool.reliefs.targets import Weights
from nmaptool.solver.tiling.grid import TileGrid


class TileJob(Protocol):
    """What the tasks of every pass know."""

    @property
    def folder(self) -> WorkFolder:
        """Holds a record of each finished tile."""

    @property
    def grid(self) -> TileGrid:
        """The tiles."""


@dataclass(frozen=True)
class ReliefJob:
    """A relief by tiles.

    Attributes
    ----------
    folder : WorkFolder
    grid : TileGrid
    original : str
        Name of the map.
    files : ReliefFiles
        Names of the other inputs.
    greys : dict of str to GreyStore
        The mask and the maps of weights, by the names of their fields. How each is read was found once.
    reading, detail_reading : ReadOptions
        How the maps are read, with nothing left to detect.
    options : ReliefOptions
    weights : Weights
        For the whole picture, without maps.
    pitch_mm : float
    margin : int
        Pixels around a tile that its system depends on.
    """

    folder: WorkFolder
    grid: TileGrid
    original: str
    files: ReliefFiles
    greys: dict[str, GreyStore]
    reading: ReadOptions
    detail_reading: ReadOptions | None
    options: ReliefOptions
    weights: Weights
    pitch_mm: float
    margin: int

    def base_of(self, load: str) -> bool:
        """Whether a load was made for the heights of a curved background; that of delta is not."""
        return self.files.surface is not None and load == "load"

    @property
    def loads(self) -> tuple[str, ...]:
        """The loads to solve for: one, or that of the shape and that of delta where their sum is found afterwards."""
        return ("load",) if self.options.fit == "scale" else ("load", "pull")

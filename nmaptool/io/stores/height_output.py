"""The store of finished heights: written under another name, and renamed when it is complete."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.opening import create_picture, open_writable
from nmaptool.io.stores.work import chunk_of


@dataclass(frozen=True)
class HeightOutput:
    """Where the heights of a large map are written: float32 mm, NaN outside the surface.

    Parameters
    ----------
    name : str
        Zarr store.
    rows, cols : int
        Pixels of the picture.
    pitch_mm : float
    at : str
        "centers": (rows, cols) heights; "corners": one more of both.
    chunk : int
        Side of the part that a task writes.
    overwrite : bool
        Replace a store that exists.

    Raises
    ------
    UsageError
        If the name does not end in .zarr.
    OutputError
        If it exists and is not to be replaced, or its folder does not exist.
    """

    name: str
    rows: int
    cols: int
    pitch_mm: float
    at: str
    chunk: int
    overwrite: bool = False

    def __post_init__(self) -> None:
        _ = self._store

    @property
    def _store(self) -> NewStore:
        return NewStore(self.name, "the relief of a large map", self.overwrite)

    @property
    def partial_name(self) -> str:
        """The name of the store until it is complete."""
        return self._store.partial_name

    def begin(self) -> None:
        """Create the store."""
        extra = 1 if self.at == "corners" else 0
        rows, cols = self.rows + extra, self.cols + extra
        create_picture(
            self.partial_name,
            rows,
            cols,
            ("Y",),
            np.float32,
            chunk=self.chunk,
            inner=chunk_of(self.chunk),
            pitch_mm=self.pitch_mm,
            attributes=self._attributes,
            overwrite=True,
        )

    @property
    def _attributes(self) -> dict[str, str]:
        return {"kind": "height", "unit": "mm", "at": self.at}

    def finish(self, low_mm: float, high_mm: float) -> None:
        """State the range of the heights, and give the store its name."""
        extent = {"height_min_mm": repr(low_mm), "height_max_mm": repr(high_mm)}
        open_writable(self.partial_name).add_attributes(extent)
        self._store.finish()


def write_heights(name: str, row: int, col: int, z_mm: NDArray[Any]) -> None:
    """Write an (h, w) window of heights in mm to a store that `HeightOutput.begin` created."""
    open_writable(name).write(row, col, z_mm.astype(np.float32))

"""The store of finished heights: written under another name, and renamed when it is complete."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.io.output.targets import exists_already
from nmaptool.io.stores.extra import fsspec_module
from nmaptool.io.stores.names import local_path
from nmaptool.io.stores.opening import create_picture, open_writable
from nmaptool.io.stores.work import chunk_of
from nmaptool.io.stores.zarr_writing import make_room

_ENDING = ".zarr"


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
        place = self.name.rstrip("/")
        if not place.endswith(_ENDING):
            raise UsageError(f"{self.name}: heights of a large map are written to a Zarr store, such as heights.zarr")
        path = local_path(place)
        if path is None:
            files, root = fsspec_module(place).core.url_to_fs(place)
            if files.exists(root) and not self.overwrite:
                raise exists_already(Path(place))
            return
        if path.exists() and not self.overwrite:
            raise exists_already(path)
        if not path.parent.is_dir():
            raise OutputError(f"{place}: the folder {path.parent} does not exist; create it first")

    @property
    def partial_name(self) -> str:
        """The name of the store until it is complete."""
        return f"{self.name.rstrip('/').removesuffix(_ENDING)}.partial{_ENDING}"

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
        place = self.name.rstrip("/")
        make_room(place, self.overwrite)
        path, partial = local_path(place), local_path(self.partial_name)
        try:
            if path is not None and partial is not None:
                partial.replace(path)
            else:
                files, root = fsspec_module(place).core.url_to_fs(place)
                files.mv(files._strip_protocol(self.partial_name), root, recursive=True)
        except OSError as error:
            raise OutputError(f"{place}: cannot be written ({reason_of(error)})") from None


def write_heights(name: str, row: int, col: int, z_mm: NDArray[Any]) -> None:
    """Write an (h, w) window of heights in mm to a store that `HeightOutput.begin` created."""
    open_writable(name).write(row, col, z_mm.astype(np.float32))

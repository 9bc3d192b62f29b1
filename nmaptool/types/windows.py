"""Pictures that are read and written by windows, never whole."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from nmaptool.types.picture import RasterImage


class PictureStore(Protocol):
    """A picture larger than memory.

    Attributes
    ----------
    name : str
        As the user gave it, for messages; `nmaptool.io.stores.opening.open_picture` opens it again in another process.
    rows, cols : int
    channels : tuple of str
        As in `RasterImage`.
    chunk : (int, int)
        Rows and columns that the store reads at once.
    pitch_mm : float or None
    attributes : mapping of str
        As in `RasterImage`.
    """

    name: str
    rows: int
    cols: int
    channels: tuple[str, ...]
    chunk: tuple[int, int]
    pitch_mm: float | None
    attributes: Mapping[str, str]

    def read(self, rows: slice, cols: slice) -> RasterImage:
        """Return one window as it is stored; its frame is that of the window.

        Raises
        ------
        InputError
            If a chunk is missing or damaged.
        """

    def stamp(self) -> str:
        """Return a text that changes when the stored pixels change, from sizes and times of files."""


class WritableStore(Protocol):
    """A store under construction; windows may be written in any order, by several processes if they are whole chunks.

    Attributes
    ----------
    name : str
    chunk : (int, int)
    """

    name: str
    chunk: tuple[int, int]

    def write(self, row: int, col: int, values: NDArray[Any]) -> None:
        """Write an (h, w) or (h, w, C) window at a row and a column."""

"""The encoding of normal maps in stores, and windows of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32
from nmaptool.io.stores.opening import create_picture, open_writable
from nmaptool.io.stores.work import chunk_of
from nmaptool.maps.codec import encode_grey, encode_map
from nmaptool.options import WriteOptions

_TYPES = {"8": np.uint8, "16": np.uint16, "half": np.float16, "float": np.float32}


@dataclass(frozen=True)
class MapLayout:
    """How a normal map is stored.

    Parameters
    ----------
    rows, cols : int
    pitch_mm : float or None
    chunk : int
        Side of the part that a task writes.
    has_alpha : bool
        Whether the coverage is stored; without it, the map is defined everywhere.
    options : WriteOptions
        Bits "auto" are 16.
    attributes : mapping
        More metadata, such as the recipe.
    """

    rows: int
    cols: int
    pitch_mm: float | None
    chunk: int
    has_alpha: bool
    options: WriteOptions = field(default_factory=WriteOptions)
    attributes: Mapping[str, str] = field(default_factory=dict)

    @property
    def bits(self) -> str:
        """The bits, "8", "16", "half" or "float"."""
        return "16" if self.options.bits == "auto" else self.options.bits

    @property
    def zero_code(self) -> str:
        """The code of zero, for integers."""
        return "127.5" if self.options.write_zero_code == "auto" else self.options.write_zero_code

    def create(self, name: str) -> None:
        """Create the store; for an array of a group, ``group.zarr:array``.

        Raises
        ------
        OutputError
            If it cannot be created.
        """
        is_float = self.bits in ("half", "float")
        coding = {"encoding": "signed"} if is_float else {"zero_code": self.zero_code}
        create_picture(
            name,
            self.rows,
            self.cols,
            ("R", "G", "B", "A") if self.has_alpha else ("R", "G", "B"),
            _TYPES[self.bits],
            chunk=self.chunk,
            inner=chunk_of(self.chunk),
            pitch_mm=self.pitch_mm,
            attributes={
                "version": __version__,
                "kind": "normal",
                "green": self.options.write_green,
                **coding,
                **self.attributes,
            },
            overwrite=True,
        )

    def encoded(self, normals: Float32, coverage: Float32) -> NDArray[Any]:
        """(h, w, 3 or 4): the stored values of a window, as those of a file."""
        depth = 32 if self.bits in ("half", "float") else int(self.bits)
        shown = coverage if self.has_alpha else None
        pixels = encode_map(normals, shown, depth, green=self.options.write_green, zero_code=self.zero_code)
        return pixels.astype(_TYPES[self.bits], copy=False)

    def write(self, name: str, row: int, col: int, normals: Float32, coverage: Float32) -> None:
        """Write a window at a row and a column of a store that `create` made.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        open_writable(name).write(row, col, self.encoded(normals, coverage))


def create_grey(name: str, rows: int, cols: int, chunk: int, pitch_mm: float | None) -> None:
    """Create a store of 8-bit grey, such as a mask."""
    create_picture(
        name, rows, cols, ("Y",), np.uint8, chunk=chunk, inner=chunk_of(chunk), pitch_mm=pitch_mm, overwrite=True
    )


def write_grey(name: str, row: int, col: int, values: Float32) -> None:
    """Write an (h, w) window of values in [0, 1] to a store that `create_grey` made."""
    open_writable(name).write(row, col, encode_grey(values, 8))

"""Limits for what a workspace file declares, checked before any of it is decoded."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.size_limit import check_size

MOST_LAYERS = 8000
_DEEPEST_GROUP = 64
_LONGEST_SIDE = 300_000


class Budget:
    """Adds up the pixels that the layers of a file declare.

    Parameters
    ----------
    path : Path
        For messages.
    max_megapixels : float
        Limit for the canvas, and for all layers and masks together.
    """

    def __init__(self, path: Path, max_megapixels: float) -> None:
        self._path, self._limit, self._pixels = path, max_megapixels, 0

    def check_count(self, layers: int) -> None:
        """Raise a LimitError if there are more layers than `MOST_LAYERS`."""
        if layers > MOST_LAYERS:
            raise LimitError(f"{self._path}: holds {layers} layers, more than the limit of {MOST_LAYERS}; merge some")

    def check_depth(self, depth: int) -> None:
        """Raise an InputError if groups are nested too deeply."""
        if depth > _DEEPEST_GROUP:
            raise InputError(f"{self._path}: groups are nested more than {_DEEPEST_GROUP} deep; merge some")

    def add(self, name: str, cols: int, rows: int) -> None:
        """Count a layer's rectangle.

        Raises
        ------
        LimitError
            If it, or all layers together, are over the limit.
        """
        if cols < 1 or rows < 1:
            return
        shown = "".join(c if c.isprintable() else "?" for c in name[:60])
        if max(cols, rows) > _LONGEST_SIDE:
            raise LimitError(
                f"{self._path}: layer {shown!r} declares {cols} x {rows} px; the limit is {_LONGEST_SIDE} px a side"
            )
        check_size(Path(f"{self._path}: layer {shown!r}"), cols, rows, self._limit)
        self._pixels += cols * rows
        if self._pixels > self._limit * 1e6:
            raise LimitError(
                f"{self._path}: its layers and masks hold more than {self._limit:g} megapixels together; crop them or "
                "raise `max_megapixels`"
            )

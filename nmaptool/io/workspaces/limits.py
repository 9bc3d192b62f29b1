"""What a workspace file may claim before any of it is decoded."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.png import check_size

MOST_LAYERS = 8000
_DEEPEST_GROUP = 64
_LONGEST_SIDE = 300_000


class Budget:
    """Sums the pixels that a file's layers claim.

    Parameters
    ----------
    path : Path
        For messages.
    max_megapixels : float
        Of the canvas, and of all layers and masks together.
    """

    def __init__(self, path: Path, max_megapixels: float) -> None:
        self._path, self._limit, self._pixels = path, max_megapixels, 0

    def check_count(self, layers: int) -> None:
        """Refuse more layers than any designer makes, by a LimitError."""
        if layers > MOST_LAYERS:
            raise LimitError(f"{self._path}: holds {layers} layers; accepted are at most {MOST_LAYERS}")

    def check_depth(self, depth: int) -> None:
        """Refuse groups in groups without end, by an InputError."""
        if depth > _DEEPEST_GROUP:
            raise InputError(f"{self._path}: nests groups more than {_DEEPEST_GROUP} deep; merge some")

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
                f"{self._path}: layer {shown!r} claims {cols} x {rows} px; accepted are sides up to {_LONGEST_SIDE}"
            )
        check_size(Path(f"{self._path}: layer {shown!r}"), cols, rows, self._limit)
        self._pixels += cols * rows
        if self._pixels > self._limit * 1e6:
            raise LimitError(
                f"{self._path}: its layers and masks hold more than {self._limit:g} megapixels together; crop them or "
                "raise `max_megapixels`"
            )

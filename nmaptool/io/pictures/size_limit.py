"""The limit on the size of a picture."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import LimitError


def check_size(path: Path, cols: int, rows: int, max_megapixels: float) -> None:
    """Refuse a picture over the limit, before anything is allocated.

    Raises
    ------
    LimitError
    """
    megapixels = cols * rows / 1e6
    if megapixels > max_megapixels:
        stated = f"{megapixels:.0f}" if megapixels >= 10 else f"{megapixels:.2g}"
        raise LimitError(
            f"{path}: {cols} x {rows} is {stated} megapixels, more than the limit of {max_megapixels:g}; "
            "make it smaller or raise `max_megapixels`"
        )

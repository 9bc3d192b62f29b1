"""Rows of numbers as text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

_BAND_ROWS = 1 << 14


def rows_as_text(row: str, values: NDArray[Any]) -> Iterator[bytes]:
    """Each row of an (n, k) array by a format with k places, many rows at a time.

    >>> import numpy as np
    >>> list(rows_as_text("%d %d;", np.array([[1, 2], [3, 4]])))
    [b'1 2;3 4;']
    """
    for first in range(0, len(values), _BAND_ROWS):
        band = values[first : first + _BAND_ROWS]
        yield (row * len(band) % tuple(band.ravel().tolist())).encode()

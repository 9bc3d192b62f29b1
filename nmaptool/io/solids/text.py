"""Rows of three numbers as text."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.core.arrays import Float64
from nmaptool.types.solid import Faces

_BUFFER_BYTES = 1 << 20


def words_of(row: str) -> bytes:
    r"""What stands around the three numbers of a row, marked by ``#``, as the loops of `nmaptool.kernels` take it.

    >>> words_of("v # # #;")
    b'v \x00 \x00 \x00;\x00'
    """
    return row.replace("#", "\0").encode("ascii") + b"\0"


def decimals_as_text(values: Float64, words: bytes, digits: int | None = None) -> Iterator[bytes]:
    """Each row of an (n, 3) array as text, with ``digits`` decimals or as "%.9g", many rows at a time.

    >>> list(decimals_as_text(np.array([[1, 0.25, -3]]), words_of("v # # #;"), 2))
    [b'v 1.00 0.25 -3.00;']
    """
    count = -1 if digits is None else digits
    rows = np.ascontiguousarray(values, np.float64)
    return _written(rows, lambda left, out, state: kernels.decimal_rows(left, words, count, out, state))


def wholes_as_text(values: Faces, words: bytes, first: int = 0) -> Iterator[bytes]:
    """The same for whole numbers, to which ``first`` is added.

    >>> list(wholes_as_text(np.array([[1, 0, 3]], np.int32), words_of("f # # #;"), 1))
    [b'f 2 1 4;']
    """
    rows = np.ascontiguousarray(values, np.int32)
    return _written(rows, lambda left, out, state: kernels.whole_rows(left, first, words, out, state))


def _written(
    values: NDArray[Any], write: Callable[[NDArray[Any], NDArray[np.uint8], NDArray[np.int64]], float]
) -> Iterator[bytes]:
    out, state = np.empty(_BUFFER_BYTES, np.uint8), np.zeros(2, np.int64)
    while len(values):
        write(values, out, state)
        size, rows = state.tolist()
        yield out[:size].tobytes()
        values = values[rows:]

"""Rows of three numbers as text, and back, in Python: the twin of ``text.h`` and ``text_rows.h``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int32]
Whole = NDArray[np.int64]

# room for the longest row, of numbers of up to 720 characters and words of up to 64
_LONGEST_ROW = 3 * (720 + 64) + 64
_BAND_ROWS = 1 << 14
_GREATEST = 2**31 - 1


def decimal_rows(values: Float64, words: bytes, digits: int, out: Bytes, state: Whole) -> float:
    """Write rows of numbers as text, from the first on, as long as there is room for the longest row.

    Parameters
    ----------
    values : (n, 3) float64
    words : bytes
        What stands before, between and after the numbers: four texts, each with a zero byte after it.
    digits : int
        Numbers are written as "%.{digits}f"; if it is negative, as "%.9g".
    out : (m,) uint8
    state : (2,) int64
        Gets the numbers of bytes and of rows that were written.
    """
    form = "%.9g" if digits < 0 else f"%.{digits}f"
    return _write(values, form, words, out, state)


def whole_rows(values: Ints, first: int, words: bytes, out: Bytes, state: Whole) -> float:
    """The same for rows of int32, to each of which ``first`` is added."""
    return _write(values.astype(np.int64) + first, "%d", words, out, state)


def _write(values: NDArray[Any], form: str, words: bytes, out: Bytes, state: Whole) -> float:
    row = form.join(words.decode("ascii").split("\0")[:3]) + form + words.decode("ascii").split("\0")[3]
    band = values[: min(_BAND_ROWS, max(1, out.size // _LONGEST_ROW))]
    text = np.frombuffer((row * len(band) % tuple(band.ravel().tolist())).encode(), np.uint8)
    out[: len(text)] = text
    state[:] = len(text), len(band)
    return 0.0


def read_decimal_rows(text: bytes, words: bytes, first: int, out: Float64, state: Whole) -> float:
    """Read rows of numbers until one has another form, or ``out`` is full.

    Parameters
    ----------
    text : bytes
    words : bytes
        As for `decimal_rows`; the last one ends a line.
    first : int
        Ignored.
    out : (m, 3) float64
        Correct to a few units in the last place.
    state : (2,) int64
        Where to begin; gets the place after the last row, and the number of rows.
    """
    return _read(text, words, np.dtype(np.float64), 0, out, state)


def read_whole_rows(text: bytes, words: bytes, first: int, out: Ints, state: Whole) -> float:
    """The same for whole numbers, from which ``first`` is subtracted; the results must be int32."""
    return _read(text, words, np.dtype(np.int64), first, out, state)


def _read(text: bytes, words: bytes, kind: np.dtype[Any], first: int, out: NDArray[Any], state: Whole) -> float:
    pieces = words.split(b"\0")[:4]
    begin, most = int(state[0]), out.size // 3
    state[1] = 0
    lines = []
    for line in text[begin:].splitlines(keepends=True)[:most]:
        if not (line.startswith(pieces[0]) and line.endswith(pieces[3])):
            break
        lines.append(line)
    joined = b"".join(lines)
    for piece in pieces:
        joined = joined.replace(piece, b" ")
    try:
        values = np.array(joined.split(), kind) - first
    except (ValueError, OverflowError):
        return 0.0
    fits = kind.kind == "f" or not values.size or (values.min() >= -_GREATEST and values.max() <= _GREATEST)
    if values.size == 3 * len(lines) and fits:
        out.reshape(-1)[: values.size] = values
        state[:] = begin + sum(map(len, lines)), len(lines)
    return 0.0

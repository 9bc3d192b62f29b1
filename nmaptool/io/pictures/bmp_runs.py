"""Unpack the run lengths of BMP files of 4 and 8 bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_END_OF_ROW, _END, _STEP = 0, 1, 2


def unpack_runs(data: bytes, cols: int, rows: int, bits: int) -> NDArray[np.uint8] | None:
    """(rows, cols) places in the palette, or None if the data end early or leave the picture.

    Pixels that the data skip are 0, as the format says.
    """
    out = bytearray(rows * cols)
    at, row, col = 0, 0, 0
    while at + 1 < len(data):
        count, value = data[at], data[at + 1]
        at += 2
        if count:
            codes = bytes([value]) * count if bits == 8 else (bytes([value >> 4, value & 15]) * 128)[:count]
        elif value == _END_OF_ROW:
            row, col = row + 1, 0
            continue
        elif value == _END:
            return np.frombuffer(out, np.uint8).reshape(rows, cols)
        elif value == _STEP:
            if at + 1 >= len(data):
                return None
            row, col, at = row + data[at + 1], col + data[at], at + 2
            continue
        else:
            size = (value * bits + 7) // 8
            codes = _codes(data[at : at + size], bits)[:value]
            at += size + size % 2
            if len(codes) < value:
                return None
        if row >= rows or col + len(codes) > cols + (bits == 4):  # an odd width may end in half a byte
            return None
        room = min(len(codes), cols - col)
        start = row * cols + col
        out[start : start + room] = codes[:room]
        col += room
    return None


def _codes(packed: bytes, bits: int) -> bytes:
    """The places in a palette, one per byte."""
    if bits == 8:
        return packed
    values = np.frombuffer(packed, np.uint8)
    return np.column_stack([values >> 4, values & 15]).tobytes()

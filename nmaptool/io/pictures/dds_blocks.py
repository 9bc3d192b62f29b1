"""Unpack signed BC4 and BC5 blocks: 4 x 4 pixels as two ends of a range and 3 bits per pixel."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Float64

_CODES_PER_BLOCK = 16


def unpack_signed(data: bytes, rows: int, cols: int, count: int) -> Float32:
    """Return (rows, cols, count) float32 in [-1, 1].

    Parameters
    ----------
    data : bytes
        The blocks of all pixels, row by row; each has 8 bytes per channel.
    rows, cols : int
    count : int
        Channels: 1 (BC4) or 2 (BC5).
    """
    down, across = -(-rows // 4), -(-cols // 4)
    blocks = np.frombuffer(data, np.uint8).reshape(down * across * count, 8)
    ends = np.maximum(blocks[:, :2].view(np.int8), -127).astype(np.float64) / 127
    table = _range_of(ends[:, 0], ends[:, 1])
    packed = np.zeros(len(blocks), np.uint64)
    for place in range(6):
        packed |= blocks[:, 2 + place].astype(np.uint64) << np.uint64(8 * place)
    out = np.empty((len(blocks), _CODES_PER_BLOCK), np.float32)
    for pixel in range(_CODES_PER_BLOCK):
        index = (packed >> np.uint64(3 * pixel)) & np.uint64(7)
        out[:, pixel] = np.take_along_axis(table, index.astype(np.intp)[:, None], axis=1)[:, 0]
    tiles = out.reshape(down, across, count, 4, 4).transpose(0, 3, 1, 4, 2)
    return np.ascontiguousarray(tiles.reshape(down * 4, across * 4, count)[:rows, :cols])


def _range_of(first: Float64, second: Float64) -> Float64:
    """(n, 8) float64: the values of the codes 0 to 7; 6 and 7 are -1 and 1 unless the first end is the larger."""
    table = np.empty((len(first), 8))
    table[:, 0], table[:, 1] = first, second
    for step in range(1, 7):
        table[:, 1 + step] = ((7 - step) * first + step * second) / 7
    few = first <= second
    for step in range(1, 5):
        table[few, 1 + step] = ((5 - step) * first[few] + step * second[few]) / 5
    table[few, 6], table[few, 7] = -1, 1
    return table

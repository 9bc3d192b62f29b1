"""Unpack BC4 and BC5 blocks: 4 x 4 pixels as two ends of a range and 3 bits per pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64

_CODES_PER_BLOCK = 16


def unpack_blocks(data: bytes, shape: tuple[int, int, int], *, signed: bool) -> NDArray[Any]:
    """Return the pixels of blocks: uint8 codes, or float32 in [-1, 1] of signed blocks.

    Parameters
    ----------
    data : bytes
        The blocks of all pixels, row by row; each has 8 bytes per channel.
    shape : tuple of int
        Rows, columns, and channels: 1 (BC4) or 2 (BC5).
    signed : bool
    """
    rows, cols, count = shape
    down, across = -(-rows // 4), -(-cols // 4)
    blocks = np.frombuffer(data, np.uint8).reshape(down * across * count, 8)
    if signed:
        ends = np.maximum(blocks[:, :2].view(np.int8), -127) / 127
        values = _range_of(ends[:, 0], ends[:, 1], -1, 1).astype(np.float32)
    else:
        ends = blocks[:, :2].astype(np.float64)
        values = np.floor(_range_of(ends[:, 0], ends[:, 1], 0, 255) + 0.5).astype(np.uint8)
    packed = np.zeros(len(blocks), np.uint64)
    for place in range(6):
        packed |= blocks[:, 2 + place].astype(np.uint64) << np.uint64(8 * place)
    out = np.empty((len(blocks), _CODES_PER_BLOCK), values.dtype)
    for pixel in range(_CODES_PER_BLOCK):
        index = (packed >> np.uint64(3 * pixel)) & np.uint64(7)
        out[:, pixel] = np.take_along_axis(values, index.astype(np.intp)[:, None], axis=1)[:, 0]
    tiles = out.reshape(down, across, count, 4, 4).transpose(0, 3, 1, 4, 2)
    return np.ascontiguousarray(tiles.reshape(down * 4, across * 4, count)[:rows, :cols])


def _range_of(first: Float64, second: Float64, low: float, high: float) -> Float64:
    """(n, 8): the values of the codes 0 to 7; unless the first end is the larger, the last two are low and high."""
    table = np.empty((len(first), 8))
    table[:, 0], table[:, 1] = first, second
    for step in range(1, 7):
        table[:, 1 + step] = ((7 - step) * first + step * second) / 7
    few = first <= second
    for step in range(1, 5):
        table[few, 1 + step] = ((5 - step) * first[few] + step * second[few]) / 5
    table[few, 6], table[few, 7] = low, high
    return table

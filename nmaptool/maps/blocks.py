"""The blocks of lossy compression (JPEG) in a picture, whatever its format now."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_BLOCK = 8
# larger steps belong to the motif
_LARGEST_STEP = 4
# steps between blocks are this many times those inside them, and stand out this much from those at any other place
_STANDS_OUT, _FROM_NEXT = 1.2, 1.15
# blocks step at most of their edges; edges of a motif that lie at eighth pixels are few
_LEAST_SHARE = 0.67
_LEAST_BLOCKS = 6
_WINDOW_PX = 1024


def shows_blocks(codes: NDArray[Any]) -> bool:
    """Whether (H, W, C) uint8 codes step more often at every eighth pixel, across and down, than between."""
    codes = codes[:_WINDOW_PX, :_WINDOW_PX].astype(np.int16)
    return min(codes.shape[:2]) >= _LEAST_BLOCKS * _BLOCK and all(
        _stands_out(np.abs(np.diff(codes, axis=axis)), axis) for axis in (0, 1)
    )


def _stands_out(steps: NDArray[np.int16], axis: int) -> bool:
    """Whether the mean small step is larger between blocks than at the seven other places."""
    size = np.minimum(steps, _LARGEST_STEP).mean(axis=(1 - axis, 2))
    mean = np.array([size[place::_BLOCK].mean() for place in range(_BLOCK)])
    between, rest = mean[-1], mean[:-1]
    if not (between > _STANDS_OUT * np.median(rest) and between > _FROM_NEXT * rest.max()):
        return False
    lines = size[: len(size) // _BLOCK * _BLOCK].reshape(-1, _BLOCK)
    edge, inside = lines[:, -1], np.median(lines[:, :-1], axis=1)
    steps_there = (edge > inside)[(edge > 0) | (inside > 0)]
    return len(steps_there) >= _LEAST_BLOCKS and bool(steps_there.mean() > _LEAST_SHARE)

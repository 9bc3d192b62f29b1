"""Sums over the cells around each pixel, in NumPy: the twin of ``pixels.h``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32

Whole = NDArray[np.int64]


def pixel_sums(
    guide: Float32,
    sources: Float32,
    levels: Whole,
    shifts: Whole,
    log_weights: Float32,
    start: int,
    stop: int,
    out: Float32,
) -> None:
    """Write the sums of the cells around each pixel, weighted by distance and similarity of the guide, to ``out``.

    Parameters
    ----------
    guide : (3, N) float32
        Vectors whose squared distances are exponents.
    sources : (L, 3, N) float32
        Sums of the cell around each pixel, for each level of cells.
    levels, shifts : (C,) int64
        Level of each cell, and the distance of its centre in memory.
    log_weights : (C,) float32
        Logarithms of the weights by distance, at most 0.
    start, stop : int
        The pixels whose sums are written.
    out : (3, stop - start) float32
    """
    here = guide[:, start:stop]
    apart = np.empty_like(here)
    weight = np.empty_like(here[0])
    out[:] = 0
    for level, shift, log_weight in zip(levels.tolist(), shifts.tolist(), log_weights, strict=True):
        there = slice(start + shift, stop + shift)
        np.subtract(guide[:, there], here, out=apart)
        np.multiply(apart, apart, out=apart)
        np.add(apart[0], apart[1], out=weight)
        np.add(weight, apart[2], out=weight)
        np.subtract(log_weight, weight, out=weight)
        np.exp(weight, out=weight)
        np.multiply(sources[level][:, there], weight, out=apart)
        np.add(out, apart, out=out)

"""Pixels of smoothed outlines that are part of both sides of a jump."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.steps import JumpRule, jump_heights, steps_along
from nmaptool.depth.tiles import along

# three pixels on either side of a mixed one
LEAST_SIDE = 7
# a mixed pixel's step against the slope behind it: where it is plain, and where outlines are known to be smoothed
_PLAIN, _SMOOTHED = 3.0, 1.5
_STEEPEN = 1.6
Places = tuple[NDArray[np.intp], NDArray[np.intp]]


def _main(heights: Float32, known: Mask, near: Mask, rule: JumpRule, axis: int) -> tuple[Float32, Float32]:
    """Steps, and the heights of the jumps on lines at their largest steps."""
    steps = steps_along(heights, known, axis)
    _, main = jump_heights(steps, rule, axis)
    main *= near[along(axis, None, -1)]
    return steps, main


def count_ends(heights: Float32, known: Mask, near: Mask, rule: JumpRule, axis: int) -> tuple[int, int]:
    """How many ends of jumps are plainly mixed, and how many ends there are.

    Parameters
    ----------
    heights : (H, W) float32
    known, near : (H, W) bool
        Pixels that have a height; pixels on lines of jumps.
    rule : JumpRule
    axis : int
    """
    if heights.shape[axis] < LEAST_SIDE:
        return 0, 0
    steps, main = _main(heights, known, near, rule, axis)
    place = np.nonzero(main)
    found = [_mixed_ends(heights, steps, main, rule, axis, forward, _PLAIN)[1] for forward in (True, False)]
    return sum(map(len, found)), 2 * len(place[0])


def moved_ends(
    heights: Float32, known: Mask, near: Mask, rule: JumpRule, axis: int, smoothed: bool
) -> tuple[Float32, Float32]:
    """Where mixed pixels belong along one axis.

    Parameters
    ----------
    heights, known, near, rule, axis
        As in `count_ends`.
    smoothed : bool
        Outlines are smoothed: what is a little outside the slope is mixed, too.

    Returns
    -------
    value : (H, W) float32
        The height that continues the side a mixed pixel belongs to.
    weight : (H, W) float32
        Height of the jump; 0 where the pixel is not mixed.
    """
    value, weight = np.zeros_like(heights), np.zeros_like(heights)
    if heights.shape[axis] < LEAST_SIDE:
        return value, weight
    steps, main = _main(heights, known, near, rule, axis)
    for forward in (True, False):
        ratio = _SMOOTHED if smoothed else _PLAIN
        place, new, size = _mixed_ends(heights, steps, main, rule, axis, forward, ratio)
        old, old_size = value[place], weight[place]
        # a pixel half way belongs to the side in front
        value[place] = np.where(size > old_size, new, np.where(size == old_size, np.maximum(new, old), old))
        weight[place] = np.maximum(size, old_size)
    return value, weight


def _mixed_ends(
    heights: Float32, steps: Float32, main: Float32, rule: JumpRule, axis: int, forward: bool, ratio: float
) -> tuple[Places, Float32, Float32]:
    """The pixels behind (or before) jumps whose own next step goes on in the jump's direction, far outside the slope.

    Returns
    -------
    place : pair of (K,) int
        Rows and columns of mixed pixels.
    new, size : (K,) float32
        The height that continues the pixels beyond, and that of the jump.
    """
    rows, cols = np.nonzero(main)
    at, limit = (rows, cols)[axis], heights.shape[axis]
    fits = (at + 5 <= limit) if forward else (at >= 3)  # three pixels beyond the mixed one
    rows, cols = rows[fits], cols[fits]

    def moved(by: int) -> Places:
        return (rows + by, cols) if axis == 0 else (rows, cols + by)

    pixel, beyond = (moved(1), moved(2)) if forward else (moved(0), moved(-1))
    following, slope, behind = (steps[moved(by if forward else -by)] for by in (1, 2, 3))
    run = following * np.sign(steps[rows, cols])
    mixed = (run >= np.float32(rule.least_mixed)) & (run > np.float32(ratio) * np.abs(slope))
    # the slope that goes on is no steeper than the one behind it allows
    most = np.float32(_STEEPEN) * np.abs(behind) + np.float32(rule.noise + rule.least_mixed / 2)
    slope = np.clip(slope, -most, most)
    new = heights[beyond] + (-slope if forward else slope)
    return (pixel[0][mixed], pixel[1][mixed]), new[mixed], main[rows, cols][mixed]

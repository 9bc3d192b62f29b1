"""Where one surface hides another: links between neighbouring pixels that no slope is taken across.

A step between two pixels is a jump where it is far outside the slopes beside it. Outlines that were smoothed hold
pixels that are part of both sides; these are found first and moved to the side they mostly belong to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.fit import along
from nmaptool.depth.tiles import Tile, for_tiles

# a step is a jump where it exceeds both slopes beside it so many times, or the flatter one and the steeper one
_BOTH_SIDES = np.float32(3)
_FLAT_SIDE, _STEEP_SIDE = np.float32(8), np.float32(1.4)
# a smoothed jump: its largest step holds this share of three, and all three so many times the slopes beside them
_PEAK = np.float32(0.42)
_SOFT_FLAT, _SOFT_STEEP = np.float32(24), np.float32(3.6)
# a mixed pixel's step against the slope behind it: where it is plain, and where outlines are known to be smoothed
_MIXED, _MIXED_TOO = np.float32(3), np.float32(1.5)
# outlines are smoothed where so many ends of jumps are plainly mixed
_SMOOTHED_SHARE = 0.15
_HALO = 6
# two pixels on either side of a mixed one
_LEAST_SIDE = 5


@dataclass(frozen=True)
class JumpRule:
    """What counts as a jump.

    Attributes
    ----------
    least : float
        Smallest jump, in the heights' own unit.
    least_mixed : float
        Smallest step by which a pixel is taken for a mixture of two sides.
    by_hand : bool
        Every step of ``least`` is a jump, whatever the slopes beside it.
    """

    least: float
    least_mixed: float
    by_hand: bool = False


def join_all(known: Mask) -> tuple[Mask, Mask]:
    """Links between all known neighbours: (H, W) bool to the right, and below."""
    across, down = known.copy(), known.copy()
    across[:, :-1] &= known[:, 1:]
    down[:-1] &= known[1:]
    across[:, -1] = False
    down[-1] = False
    return across, down


def unmix(heights: Float32, known: Mask, rule: JumpRule) -> tuple[Float32, int]:
    """Heights with the mixed pixels of smoothed outlines moved to the side that they mostly belong to.

    Parameters
    ----------
    heights : (H, W) float32
    known : (H, W) bool
        Pixels that have a height.
    rule : JumpRule

    Returns
    -------
    heights : (H, W) float32
        A copy.
    count : int
        Pixels moved.
    """
    plain, ends = _survey(heights, known, rule)
    if plain == 0:
        return heights, 0
    ratio = _MIXED_TOO if plain >= _SMOOTHED_SHARE * ends else _MIXED
    out = np.empty_like(heights)
    counts = []

    def work(tile: Tile) -> None:
        part = heights[tile.outer]
        found = [_moves(part, known[tile.outer], rule, axis, ratio) for axis in (0, 1)]
        (value, weight), (other, other_weight) = found
        value = np.where(other_weight > weight, other, value)
        equal = (other_weight == weight) & (weight > 0)
        value = np.where(equal, (value + other) * np.float32(0.5), value)
        moved = np.maximum(weight, other_weight) > 0
        out[tile.core] = np.where(moved, value, part)[tile.inner]
        counts.append(int(np.count_nonzero(moved[tile.inner])))

    for_tiles(heights.shape, _HALO, work)
    return out, sum(counts)


def _survey(heights: Float32, known: Mask, rule: JumpRule) -> tuple[int, int]:
    """How many ends of jumps are plainly mixed, and how many ends there are."""
    plain, ends = [], []

    def work(tile: Tile) -> None:
        part = heights[tile.outer]
        for axis in (0, 1):
            if part.shape[axis] < _LEAST_SIDE:
                continue
            steps = _steps(part, known[tile.outer], axis)
            main = _main_steps(steps, rule, axis)
            count = int(np.count_nonzero(main))
            if not count:
                continue
            ends.append(2 * count)
            for forward in (True, False):
                plain.append(len(_mixed_ends(part, steps, main, rule, axis, forward, _MIXED)[1]))

    for_tiles(heights.shape, _HALO, work)
    return sum(plain), sum(ends)


def cut_links(heights: Float32, known: Mask, rule: JumpRule) -> tuple[Mask, Mask]:
    """Links that do not cross a jump.

    Parameters
    ----------
    heights : (H, W) float32
        Without mixed pixels.
    known : (H, W) bool
    rule : JumpRule

    Returns
    -------
    across, down : (H, W) bool
        Whether a pixel is joined to the next one to the right, or below.
    """
    across, down = join_all(known)

    def work(tile: Tile) -> None:
        for links, axis in ((down, 0), (across, 1)):
            steps = _steps(heights[tile.outer], known[tile.outer], axis)
            jump = np.zeros(heights[tile.outer].shape, bool)
            jump[along(axis, None, -1)] = _crisp(steps, rule, axis)
            links[tile.core] &= ~jump[tile.inner]

    for_tiles(heights.shape, _HALO, work)
    return across, down


def _steps(heights: Float32, known: Mask, axis: int) -> Float32:
    """Steps to the next pixel; 0 to an unknown one."""
    first, last = along(axis, None, -1), along(axis, 1, None)
    steps = heights[last] - heights[first]
    steps *= known[last] & known[first]
    return steps


def _shifted(steps: Float32, axis: int, by: int) -> Float32:
    """``steps[i + by]`` at i; 0 beyond the ends."""
    out = np.zeros_like(steps)
    if by > 0:
        out[along(axis, None, -by)] = steps[along(axis, by, None)]
    else:
        out[along(axis, -by, None)] = steps[along(axis, None, by)]
    return out


def _crisp(steps: Float32, rule: JumpRule, axis: int) -> Mask:
    size = np.abs(steps)
    big = size >= np.float32(rule.least)
    if rule.by_hand or not big.any():
        return np.asarray(big)
    before, after = _shifted(size, axis, -1), _shifted(size, axis, 1)
    flat, steep = np.minimum(before, after), np.maximum(before, after)
    outside = size > _BOTH_SIDES * steep
    outside |= (size > _FLAT_SIDE * flat) & (size > _STEEP_SIDE * steep)
    return np.asarray(big & outside)


def _main_steps(steps: Float32, rule: JumpRule, axis: int) -> Float32:
    """The whole height of a jump at its largest step, 0 where there is none; it may take three steps."""
    zero = np.float32(0)
    before, after = _shifted(steps, axis, -1), _shifted(steps, axis, 1)
    size = np.abs(steps)
    same = np.sign(steps)
    run_before, run_after = np.maximum(before * same, zero), np.maximum(after * same, zero)
    total = size + run_before
    total += run_after
    peak = (size >= run_before) & (size >= run_after) & (size >= _PEAK * total) & (total >= np.float32(rule.least))
    if rule.by_hand:
        return np.where(peak, total, zero)
    crisp = _crisp(steps, rule, axis)
    outer = np.abs(_shifted(steps, axis, -2)), np.abs(_shifted(steps, axis, 2))
    flat, steep = np.minimum(*outer), np.maximum(*outer)
    soft = (total > _BOTH_SIDES * np.float32(3) * steep) | (
        (total > _SOFT_FLAT * flat) & (total > _SOFT_STEEP * steep)
    )
    return np.where(crisp | (peak & soft), total, zero)


def _moves(
    heights: Float32, known: Mask, rule: JumpRule, axis: int, ratio: np.float32
) -> tuple[Float32, Float32]:
    """Where mixed pixels belong along one axis: their new height, and the jump's size (0: not mixed)."""
    value, weight = np.zeros_like(heights), np.zeros_like(heights)
    if heights.shape[axis] < _LEAST_SIDE:
        return value, weight
    steps = _steps(heights, known, axis)
    main = _main_steps(steps, rule, axis)
    if not main.any():
        return value, weight
    for forward in (True, False):
        place, new, size = _mixed_ends(heights, steps, main, rule, axis, forward, ratio)
        old, old_size = value[place], weight[place]
        # a pixel half way belongs to the side in front
        value[place] = np.where(size > old_size, new, np.where(size == old_size, np.maximum(new, old), old))
        weight[place] = np.maximum(size, old_size)
    return value, weight


def _mixed_ends(
    heights: Float32,
    steps: Float32,
    main: Float32,
    rule: JumpRule,
    axis: int,
    forward: bool,
    ratio: np.float32,
) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], Float32, Float32]:
    """The pixels behind (or before) jumps whose own next step goes on in the jump's direction, far outside the slope.

    Returns
    -------
    place : pair of (K,) int
        Rows and columns of mixed pixels.
    new, size : (K,) float32
        The height that continues the pixels beyond, and that of the jump.
    """
    place = np.nonzero(main)
    size = main[place]
    at, limit = place[axis], heights.shape[axis]
    fits = (at + 4 <= limit) if forward else (at >= 2)  # two pixels beyond the mixed one
    place, size = tuple(index[fits] for index in place), size[fits]
    at = place[axis]

    def moved(by: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        return (at + by, place[1]) if axis == 0 else (place[0], at + by)

    pixel, beyond = (moved(1), moved(2)) if forward else (moved(0), moved(-1))
    following, slope = (steps[moved(1)], steps[moved(2)]) if forward else (steps[moved(-1)], steps[moved(-2)])
    run = following * np.sign(steps[moved(0)])
    mixed = (run >= np.float32(rule.least_mixed)) & (run > ratio * np.abs(slope))
    new = heights[beyond] + (-slope if forward else slope)
    return (pixel[0][mixed], pixel[1][mixed]), new[mixed], size[mixed]

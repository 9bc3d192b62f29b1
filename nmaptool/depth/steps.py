"""Steps between neighbouring pixels along one axis, and which of them are far outside the slopes beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.tiles import along

# a step is a jump where it exceeds both slopes beside it so many times, or the flatter one and the steeper one; the
# second set is for what only goes on with a line of jumps
_BOTH, _FLAT, _STEEP = (3.0, 2.0), (8.0, 5.0), (1.4, 1.15)
# a jump may take three steps, of which the largest holds this share
_PEAK = np.float32(0.42)
_SOFT = np.float32(2.6)


@dataclass(frozen=True)
class JumpRule:
    """What counts as a jump.

    Attributes
    ----------
    least : float
        Smallest jump, in the heights' own unit.
    least_mixed : float
        Smallest step by which a pixel is taken for a mixture of two sides.
    noise : float
        What slopes are uncertain by.
    least_line : int
        Pixels beside a line of jumps at least.
    by_hand : bool
        Every step of ``least`` is a jump, whatever the slopes beside it.
    """

    least: float
    least_mixed: float
    noise: float = 0.0
    least_line: int = 5
    by_hand: bool = False


def steps_along(heights: Float32, known: Mask, axis: int) -> Float32:
    """Steps to the next pixel along an axis, one less than there are pixels; 0 to or from an unknown one."""
    first, last = along(axis, None, -1), along(axis, 1, None)
    steps: Float32 = heights[last] - heights[first]
    steps *= known[last] & known[first]
    return steps


def shifted(steps: Float32, axis: int, by: int) -> Float32:
    """``steps[i + by]`` at i; 0 beyond the ends."""
    out = np.zeros_like(steps)
    if by > 0:
        out[along(axis, None, -by)] = steps[along(axis, by, None)]
    else:
        out[along(axis, -by, None)] = steps[along(axis, None, by)]
    return out


def _outside(size: Float32, flat: Float32, steep: Float32, width: float) -> tuple[Mask, Mask]:
    """Whether a step that is ``width`` pixels wide is far outside the slopes beside it: surely, and nearly."""
    sure, nearly = (
        (size > np.float32(both * width) * steep)
        | ((size > np.float32(one * width) * flat) & (size > np.float32(other * width) * steep))
        for both, one, other in zip(_BOTH, _FLAT, _STEEP, strict=True)
    )
    return sure, nearly


def crisp_steps(steps: Float32, rule: JumpRule, axis: int) -> tuple[Mask, Mask]:
    """Jumps that take one step: bool like ``steps``, surely and nearly."""
    size = np.abs(steps)
    big, half = size >= np.float32(rule.least), size >= np.float32(rule.least / 2)
    if rule.by_hand:
        return big, big
    if not half.any():
        return half, half
    before, after = shifted(size, axis, -1), shifted(size, axis, 1)
    before += np.float32(rule.noise)
    after += np.float32(rule.noise)
    sure, nearly = _outside(size, np.minimum(before, after), np.maximum(before, after), 1.0)
    return big & sure, half & nearly


def jump_heights(steps: Float32, rule: JumpRule, axis: int) -> tuple[Float32, Float32]:
    """The whole height of a jump at its largest step, 0 where there is none: sure ones, and those and near ones."""
    zero = np.float32(0)
    size = np.abs(steps)
    if not (size >= np.float32(rule.least / 4)).any():
        return np.zeros_like(steps), np.zeros_like(steps)
    sign = np.sign(steps)
    before, after = (np.maximum(shifted(steps, axis, by) * sign, zero) for by in (-1, 1))
    total = size + before
    total += after
    peak = (size >= before) & (size >= after) & (size >= _PEAK * total)
    big, half = total >= np.float32(rule.least), total >= np.float32(rule.least / 2)
    if rule.by_hand:
        found = np.where(peak & big, total, zero)
        return found, found
    outer = tuple(np.abs(shifted(steps, axis, by)) + np.float32(rule.noise) for by in (-2, 2))
    sure, nearly = _outside(total, np.minimum(*outer), np.maximum(*outer), float(_SOFT))
    crisp, crisp_nearly = crisp_steps(steps, rule, axis)
    strong = np.where(crisp | (peak & big & sure), total, zero)
    return strong, np.where(crisp_nearly | (peak & half & nearly), total, strong)

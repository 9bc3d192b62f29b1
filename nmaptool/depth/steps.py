"""Steps between neighbouring pixels along one axis, and which of them are much larger than the slopes beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.depth.tiles import along

# least ratios of a jump to both slopes beside it, or to the flatter and the steeper one; the second of each pair is for
# weak jumps, which only continue a line of jumps
_BOTH, _FLAT, _STEEP = (3.0, 2.0), (8.0, 5.0), (1.4, 1.15)
# a jump may spread over three steps, of which the largest has at least this share
_PEAK = np.float32(0.42)
_SOFT = 2.6
# such a jump must be higher by this factor than one of a single step, since fine texture is nearly as steep
_SOFT_LEAST = 1.6
Places = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True)
class JumpRule:
    """The criteria for a jump.

    Attributes
    ----------
    least : float
        Smallest jump, in the unit of the heights.
    least_mixed : float
        Smallest step for which a pixel counts as a mixture of two sides.
    noise : float
        Uncertainty of the slopes.
    least_line : int
        Least number of pixels beside a line of jumps.
    by_hand : bool
        Every step of at least ``least`` is a jump, whatever the slopes beside it.
    """

    least: float
    least_mixed: float
    noise: float = 0.0
    least_line: int = 5
    by_hand: bool = False

    @property
    def least_step(self) -> float:
        """Smallest possible size of the largest step in a jump, including weak ones."""
        return float(_PEAK) / 2 * self.least * (1.0 if self.by_hand else _SOFT_LEAST)


@dataclass(frozen=True, eq=False)
class Steps:
    """Steps from pixels to the next along an axis, and the two steps before and after each; 0 where a step is missing.

    Attributes
    ----------
    here : float32
        Steps, of any shape; ``before`` and ``after`` are one further, ``before2`` and ``after2`` two further.
    """

    here: Float32
    before: Float32
    after: Float32
    before2: Float32
    after2: Float32


def steps_along(heights: Float32, known: Mask, axis: int) -> Float32:
    """Return the steps to the next pixel along an axis, one fewer than pixels; 0 to or from an unknown pixel."""
    first, last = along(axis, None, -1), along(axis, 1, None)
    steps: Float32 = heights[last] - heights[first]
    steps *= known[last] & known[first]
    return steps


def all_steps(steps: Float32, axis: int) -> Steps:
    """Return every step with those beside it."""

    def shifted(by: int) -> Float32:
        out = np.zeros_like(steps)
        if by > 0:
            out[along(axis, None, -by)] = steps[along(axis, by, None)]
        else:
            out[along(axis, -by, None)] = steps[along(axis, None, by)]
        return out

    return Steps(steps, shifted(-1), shifted(1), shifted(-2), shifted(2))


def moved(place: Places, axis: int, by: int) -> Places:
    """Return places shifted along an axis."""
    rows, cols = place
    return (rows + by, cols) if axis == 0 else (rows, cols + by)


def steps_at(heights: Float32, known: Mask, axis: int, place: Places) -> dict[int, Float32]:
    """Return the step at each place and the three before and after it; 0 where a step is missing.

    Returns
    -------
    dict of int to (K,) float32
        Steps by their shift, -3 to 3.
    """
    limit = heights.shape[axis]
    values, there = [], []
    for by in range(-3, 5):
        at = moved(place, axis, by)
        inside = (at[axis] >= 0) & (at[axis] < limit)
        at = (at[0].clip(0, heights.shape[0] - 1), at[1].clip(0, heights.shape[1] - 1))
        values.append(heights[at])
        there.append(inside & known[at])
    return {by: (values[by + 4] - values[by + 3]) * (there[by + 4] & there[by + 3]) for by in range(-3, 4)}


def some_steps(steps: dict[int, Float32]) -> Steps:
    """Convert the result of `steps_at` to `Steps`."""
    return Steps(steps[0], steps[-1], steps[1], steps[-2], steps[2])


def _outside(size: Float32, one: Float32, other: Float32, width: float, noise: float) -> tuple[Mask, Mask]:
    """Return whether steps that are ``width`` pixels wide are strong jumps, and whether they are at least weak ones."""
    flat, steep = np.minimum(one, other), np.maximum(one, other)
    flat += np.float32(noise)
    steep += np.float32(noise)
    sure, nearly = (
        (size > np.float32(both * width) * steep)
        | ((size > np.float32(low * width) * flat) & (size > np.float32(high * width) * steep))
        for both, low, high in zip(_BOTH, _FLAT, _STEEP, strict=True)
    )
    return sure, nearly


def crisp_steps(steps: Steps, rule: JumpRule) -> tuple[Mask, Mask]:
    """Return the strong jumps of a single step, and those that are at least weak."""
    size = np.abs(steps.here)
    big, half = size >= np.float32(rule.least), size >= np.float32(rule.least / 2)
    if rule.by_hand:
        return big, big
    sure, nearly = _outside(size, np.abs(steps.before), np.abs(steps.after), 1.0, rule.noise)
    return big & sure, half & nearly


def jump_heights(steps: Steps, rule: JumpRule) -> tuple[Float32, Float32]:
    """Return the height of each jump at its largest step, 0 elsewhere: of strong jumps, and of strong and weak ones."""
    zero = np.float32(0)
    size, sign = np.abs(steps.here), np.sign(steps.here)
    before, after = np.maximum(steps.before * sign, zero), np.maximum(steps.after * sign, zero)
    total = size + before
    total += after
    peak = (size >= before) & (size >= after) & (size >= _PEAK * total)
    least = rule.least if rule.by_hand else _SOFT_LEAST * rule.least
    big, half = total >= np.float32(least), total >= np.float32(least / 2)
    if rule.by_hand:
        found = np.where(peak & big, total, zero)
        return found, found
    sure, nearly = _outside(total, np.abs(steps.before2), np.abs(steps.after2), _SOFT, rule.noise)
    crisp, crisp_nearly = crisp_steps(steps, rule)
    strong = np.where(crisp | (peak & big & sure), total, zero)
    return strong, np.where(crisp_nearly | (peak & half & nearly), total, strong)

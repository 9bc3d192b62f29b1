"""Mixed pixels on smoothed outlines, which belong to both sides of a jump."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places
from nmaptool.depth.steps import JumpRule, Places, jump_heights, moved, some_steps, steps_at

# least ratio of a mixed pixel's step to the slope behind it: for a clear case, and if outlines are known to be smoothed
_PLAIN, _SMOOTHED = 3.0, 1.5
# outlines count as smoothed if this share of the ends of jumps is clearly mixed
_SMOOTHED_SHARE = 0.15
# largest ratio of the slope at a mixed pixel to the slope behind it
_STEEPEN = 1.6


@dataclass(frozen=True, eq=False)
class _Ends:
    """The pixels on one side of jumps along one axis.

    Attributes
    ----------
    pixel : pair of (K,) int
        Rows and columns of the pixels next to the jump.
    run : (K,) float32
        Their step away from the jump, positive if in the direction of the jump.
    slope : (K,) float32
        Size of the next step behind.
    continued : (K,) float32
        The height extrapolated from the pixels behind.
    jump : (K,) float32
        Height of the jump.
    """

    pixel: Places
    run: Float32
    slope: Float32
    continued: Float32
    jump: Float32

    def mixed(self, rule: JumpRule, ratio: float) -> Mask:
        """Return which pixels are mixed: their step is much larger than the slope behind it."""
        return np.asarray((self.run >= np.float32(rule.least_mixed)) & (self.run > np.float32(ratio) * self.slope))


def mixed_ends(heights: Float32, known: Mask, rule: JumpRule, lines: NDArray[np.uint8]) -> tuple[int, int]:
    """Return how many ends of jumps are clearly mixed, and how many there are; arguments as for `unmixed`."""
    place = places(lines)
    ends = [end for axis in (0, 1) for end in _ends(heights, known, rule, axis, (place[0], place[1]))]
    return sum(int(np.count_nonzero(end.mixed(rule, _PLAIN))) for end in ends), sum(len(end.jump) for end in ends)


def is_smoothed(plain: int, ends: int) -> bool:
    """Whether outlines are smoothed, if this many of the ends of jumps are clearly mixed."""
    return plain >= _SMOOTHED_SHARE * ends


def unmixed(
    heights: Float32, known: Mask, rule: JumpRule, lines: NDArray[np.uint8], smoothed: bool | None = None
) -> tuple[Float32, int]:
    """Return heights with the mixed pixels of smoothed outlines moved to the side that they mostly belong to.

    Parameters
    ----------
    heights, known, rule
        As for `nmaptool.depth.jumps.part_surfaces`.
    lines : (H, W) uint8
        1 beside jumps.
    smoothed : bool, optional
        Whether outlines are smoothed. Default: found by `is_smoothed`.

    Returns
    -------
    heights : (H, W) float32
        A copy if any pixel was moved.
    count : int
        Number of pixels moved.
    """
    place = places(lines)
    ends = [end for axis in (0, 1) for end in _ends(heights, known, rule, axis, (place[0], place[1]))]
    plain = sum(int(np.count_nonzero(end.mixed(rule, _PLAIN))) for end in ends)
    if smoothed is None:
        if not plain:
            return heights, 0
        smoothed = is_smoothed(plain, sum(len(end.jump) for end in ends))
    ratio = _SMOOTHED if smoothed else _PLAIN
    chosen = [(end, end.mixed(rule, ratio)) for end in ends]
    largest, moved_before = np.zeros(heights.shape, np.float32), np.zeros(heights.shape, bool)
    for end, mixed in chosen:
        pixel = (end.pixel[0][mixed], end.pixel[1][mixed])
        largest[pixel] = np.maximum(largest[pixel], end.jump[mixed])
    out = heights.copy()
    for end, mixed in chosen:  # the larger jump decides; a pixel half-way belongs to the side in front
        decides = mixed & (end.jump >= largest[end.pixel])
        pixel = (end.pixel[0][decides], end.pixel[1][decides])
        new = end.continued[decides]
        out[pixel] = np.where(moved_before[pixel], np.maximum(out[pixel], new), new)
        moved_before[pixel] = True
    return out, int(np.count_nonzero(moved_before))


def _ends(heights: Float32, known: Mask, rule: JumpRule, axis: int, place: Places) -> list[_Ends]:
    """Return the pixels on both sides of the jumps at these places."""
    steps = steps_at(heights, known, axis, place)
    _, main = jump_heights(some_steps(steps), rule)
    found = np.nonzero(main)[0]
    place = (place[0][found], place[1][found])
    main = main[found]
    steps = {by: step[found] for by, step in steps.items()}
    sign = np.sign(steps[0])
    limit = heights.shape[axis]
    ends = []
    for side in (1, -1):
        # two pixels beyond this one must exist
        fits = (place[axis] + 4 <= limit) if side > 0 else (place[axis] >= 2)
        here = (place[0][fits], place[1][fits])
        following, slope, behind = (steps[side * by][fits] for by in (1, 2, 3))
        # the slope behind limits the extrapolated slope
        most = np.float32(_STEEPEN) * np.abs(behind) + np.float32(rule.noise / 2 + rule.least_mixed / 8)
        beyond = moved(here, axis, 2 if side > 0 else -1)
        continued = heights[beyond] - np.float32(side) * np.clip(slope, -most, most)
        pixel = moved(here, axis, 1 if side > 0 else 0)
        ends.append(_Ends(pixel, following * sign[fits], np.abs(slope), continued, main[fits]))
    return ends

"""Where one surface hides another: links between neighbouring pixels that no slope is taken across.

A step between two pixels is a jump where it is far outside the slopes beside it. Jumps make lines: a lone one is noise,
and what is nearly a jump is one where a line goes on. Outlines that were smoothed hold pixels that are part of both
sides; these are moved to the side they mostly belong to.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.mixed import LEAST_SIDE, count_ends, moved_ends
from nmaptool.depth.steps import JumpRule, crisp_steps, jump_heights, steps_along
from nmaptool.depth.tiles import Tile, along, for_tiles

# outlines are smoothed where so many ends of jumps are plainly mixed
_SMOOTHED_SHARE = 0.15
_HALO = 6
_CROSS = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Heights with their jumps known.

    Attributes
    ----------
    heights : (H, W) float32
        Mixed pixels moved to one side.
    across, down : (H, W) bool
        Whether a pixel is joined to the next one to the right, or below: both known, and no jump between.
    mixed : int
        Pixels moved.
    """

    heights: Float32
    across: Mask
    down: Mask
    mixed: int = 0


def join_all(known: Mask) -> tuple[Mask, Mask]:
    """Links between all known neighbours: (H, W) bool to the right, and below."""
    across, down = known.copy(), known.copy()
    across[:, :-1] &= known[:, 1:]
    down[:-1] &= known[1:]
    across[:, -1] = False
    down[-1] = False
    return across, down


def part_surfaces(heights: Float32, known: Mask, rule: JumpRule) -> Surfaces:
    """Find jumps and cut the links across them.

    Parameters
    ----------
    heights : (H, W) float32
    known : (H, W) bool
        Pixels that have a height.
    rule : JumpRule
    """
    across, down = join_all(known)
    lines = _lines(heights, known, rule)
    if lines is None:
        return Surfaces(heights, across, down)
    heights, mixed = _unmixed(heights, known, rule, lines)
    lines = cv2.dilate(lines, _CROSS)

    def work(tile: Tile) -> None:
        near = lines[tile.outer].view(bool)
        if not near.any():
            return
        for links, axis in ((down, 0), (across, 1)):
            steps = steps_along(heights[tile.outer], known[tile.outer], axis)
            _, weak = crisp_steps(steps, rule, axis)
            jump = np.zeros(near.shape, bool)
            jump[along(axis, None, -1)] = weak & near[along(axis, None, -1)] & near[along(axis, 1, None)]
            links[tile.core] &= ~jump[tile.inner]

    for_tiles(heights.shape, _HALO, work)
    return Surfaces(heights, across, down, mixed)


def _lines(heights: Float32, known: Mask, rule: JumpRule) -> NDArray[np.uint8] | None:
    """(H, W) uint8, 1 beside jumps that make lines; None where there are none."""
    found = np.zeros(heights.shape, np.uint8)  # 1 weak, 3 strong

    def work(tile: Tile) -> None:
        marks = np.zeros(heights[tile.outer].shape, np.uint8)
        for axis in (0, 1):
            if marks.shape[axis] < 2:
                continue
            steps = steps_along(heights[tile.outer], known[tile.outer], axis)
            strong, weak = jump_heights(steps, rule, axis)
            mark = (weak > 0).view(np.uint8) + np.uint8(2) * (strong > 0).view(np.uint8)
            marks[along(axis, None, -1)] |= mark
            marks[along(axis, 1, None)] |= mark
        found[tile.core] = marks[tile.inner]

    for_tiles(heights.shape, _HALO, work)
    if not (found > 1).any():
        return None
    count, labels = cv2.connectedComponents(found, connectivity=8, ltype=cv2.CV_32S)
    strong = np.bincount(labels[found > 1], minlength=count)
    keep = (strong >= (1 if rule.by_hand else rule.least_line)).astype(np.uint8)
    keep[0] = 0
    lines: NDArray[np.uint8] = keep[labels]
    return lines if lines.any() else None


def _unmixed(heights: Float32, known: Mask, rule: JumpRule, lines: NDArray[np.uint8]) -> tuple[Float32, int]:
    """Heights with the mixed pixels of smoothed outlines moved to one side, and how many there were."""
    plain, ends = [], []

    def survey(tile: Tile) -> None:
        near = lines[tile.outer].view(bool)
        if near.any():
            for axis in (0, 1):
                some, all_ends = count_ends(heights[tile.outer], known[tile.outer], near, rule, axis)
                plain.append(some)
                ends.append(all_ends)

    for_tiles(heights.shape, _HALO, survey)
    if sum(plain) == 0 or min(heights.shape) < LEAST_SIDE:
        return heights, 0
    smoothed = sum(plain) >= _SMOOTHED_SHARE * sum(ends)
    out = heights.copy()
    counts = []

    def move(tile: Tile) -> None:
        near = lines[tile.outer].view(bool)
        if not near.any():
            return
        part = heights[tile.outer]
        found = [moved_ends(part, known[tile.outer], near, rule, axis, smoothed) for axis in (0, 1)]
        (value, weight), (other, other_weight) = found
        value = np.where(other_weight > weight, other, value)
        equal = (other_weight == weight) & (weight > 0)
        value = np.where(equal, (value + other) * np.float32(0.5), value)
        moved = np.maximum(weight, other_weight) > 0
        np.copyto(out[tile.core], value[tile.inner], where=moved[tile.inner])
        counts.append(int(np.count_nonzero(moved[tile.inner])))

    for_tiles(heights.shape, _HALO, move)
    return out, sum(counts)

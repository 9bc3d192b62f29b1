"""Detect jumps, where one surface hides another, and cut the links between the pixels on both sides of them.

A step between two pixels is a jump if it is much larger than the slopes beside it. Jumps form lines: a lone one is
noise, and a step that is nearly large enough is a jump if it continues a line. Smoothed outlines contain mixed pixels,
which belong to both sides; they are moved to the side that they mostly belong to.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places
from nmaptool.depth.mixed import mixed_ends, unmixed
from nmaptool.depth.steps import (
    JumpRule,
    all_steps,
    crisp_steps,
    jump_heights,
    moved,
    some_steps,
    steps_along,
    steps_at,
)
from nmaptool.depth.tiles import Tile, along, for_tiles

_HALO = 6
_SIDE = 192  # many tiles contain no jump
# if the share of candidates is smaller, they are checked one by one
_FEW = 0.1
_CROSS = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Heights with detected jumps.

    Attributes
    ----------
    heights : (H, W) float32
        Heights in which mixed pixels were moved to one side.
    across, down : (H, W) bool
        Whether a pixel is joined to the next one to the right, or below: both are known, without a jump between them.
    mixed : int
        Number of pixels moved.
    """

    heights: Float32
    across: Mask
    down: Mask
    mixed: int = 0


def join_all(known: Mask) -> tuple[Mask, Mask]:
    """Return the links between all known neighbours: (H, W) bool to the right, and below."""
    across, down = known.copy(), known.copy()
    across[:, :-1] &= known[:, 1:]
    down[:-1] &= known[1:]
    across[:, -1] = False
    down[-1] = False
    return across, down


def mixed_ends_of(heights: Float32, known: Mask, rule: JumpRule) -> tuple[int, int]:
    """Return how many ends of jumps are clearly mixed, and how many there are; arguments as for `part_surfaces`."""
    lines = _lines(heights, known, rule)
    return (0, 0) if lines is None else mixed_ends(heights, known, rule, lines)


def part_surfaces(heights: Float32, known: Mask, rule: JumpRule, smoothed: bool | None = None) -> Surfaces:
    """Find jumps and cut the links across them.

    Parameters
    ----------
    heights : (H, W) float32
    known : (H, W) bool
        Pixels that have a height.
    rule : JumpRule
    smoothed : bool, optional
        Whether outlines are smoothed. Default: found in the heights.
    """
    across, down = join_all(known)
    lines = _lines(heights, known, rule)
    if lines is None:
        return Surfaces(heights, across, down)
    heights, mixed = unmixed(heights, known, rule, lines, smoothed)
    lines = cv2.dilate(lines, _CROSS)
    rows, cols = places(lines)
    for links, axis in ((down, 0), (across, 1)):
        _, nearly = crisp_steps(some_steps(steps_at(heights, known, axis, (rows, cols))), rule)
        first = (rows[nearly], cols[nearly])
        joined = links[first]
        first = (first[0][joined], first[1][joined])
        both = lines[moved(first, axis, 1)] > 0
        links[first[0][both], first[1][both]] = False
    return Surfaces(heights, across, down, mixed)


def _lines(heights: Float32, known: Mask, rule: JumpRule) -> NDArray[np.uint8] | None:
    """Return (H, W) uint8, 1 beside jumps that form lines; None if there are none."""
    found = np.zeros(heights.shape, np.uint8)  # 1 weak, 3 strong

    def work(tile: Tile) -> None:
        if np.ptp(heights[tile.outer]) < rule.least_step:
            return
        marks = np.zeros(heights[tile.outer].shape, np.uint8)
        for axis in (0, 1):
            if marks.shape[axis] < 2:
                continue
            _mark(marks, heights[tile.outer], known[tile.outer], rule, axis)
        found[tile.core] = marks[tile.inner]

    for_tiles(heights.shape, _HALO, work, _SIDE)
    if not (found > 1).any():
        return None
    return _long_lines(found, rule)


def _mark(marks: NDArray[np.uint8], heights: Float32, known: Mask, rule: JumpRule, axis: int) -> None:
    """Mark the two pixels of each jump along an axis, in place: 1 for weak jumps, 3 for strong ones."""
    steps = steps_along(heights, known, axis)
    large = np.abs(steps) >= np.float32(rule.least_step)
    count = int(np.count_nonzero(large))
    if not count:
        return
    if count > _FEW * large.size:
        strong, weak = jump_heights(all_steps(steps, axis), rule)
        mark = (weak > 0).view(np.uint8) + np.uint8(2) * (strong > 0).view(np.uint8)
        marks[along(axis, None, -1)] |= mark
        marks[along(axis, 1, None)] |= mark
        return
    rows, cols = places(large)
    strong, weak = jump_heights(some_steps(steps_at(heights, known, axis, (rows, cols))), rule)
    at = weak > 0
    mark = np.uint8(1) + np.uint8(2) * (strong[at] > 0).view(np.uint8)
    first = (rows[at], cols[at])
    for place in (first, moved(first, axis, 1)):
        marks[place] |= mark


def _long_lines(found: NDArray[np.uint8], rule: JumpRule) -> NDArray[np.uint8] | None:
    """Return the lines of marks that contain enough strong ones."""
    count, labels = cv2.connectedComponents(found, connectivity=8, ltype=cv2.CV_32S)
    strong = np.bincount(labels[found > 1], minlength=count)
    keep = (strong >= (1 if rule.by_hand else rule.least_line)).astype(np.uint8)
    keep[0] = 0
    lines: NDArray[np.uint8] = keep[labels]
    return lines if lines.any() else None

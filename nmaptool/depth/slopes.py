"""Compute slopes and normals from heights, by differences that never cross a jump."""

from __future__ import annotations

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places
from nmaptool.core.vectors import inner_vertices, mean_abs_curl
from nmaptool.depth.fit import linked_slope
from nmaptool.depth.tiles import Tile, along, for_tiles

_HALO = 4
_CENTRAL = np.array([-0.5, 0, 0.5], np.float32)
_FINE = np.array([1, -8, 0, 8, -1], np.float32) / np.float32(12)
_ONE = np.ones(1, np.float32)


def slope_along(heights: Float32, links: Mask, axis: int, fine: bool) -> Float32:
    """Return the slopes along an axis of the array.

    Parameters
    ----------
    heights : (H, W) float32
    links : (H, W) bool
        Whether a pixel is joined to the next one along the axis.
    axis : int
    fine : bool
        Use fourth-order differences where two pixels on either side are joined; they keep detail of few pixels.

    Returns
    -------
    (H, W) float32
        Central differences; one-sided beside a jump, corrected by the next bend if there is one; 0 for a pixel without
        links.
    """
    out = linked_slope(heights, links, axis)
    if heights.shape[axis] < 3:
        return out
    first, last = along(axis, None, -1), along(axis, 1, None)
    before, after = along(axis, None, -2), along(axis, 2, None)
    step = (heights[last] - heights[first]) * links[first]
    bend = step[last] - step[first]
    both = links[first][last] & links[first][first]
    # one-sided: subtract half the next bend, but no more than the step
    starts, ends = both.copy(), both.copy()
    starts[last] &= ~links[before][first]  # the pixel before is across a jump
    ends[first] &= ~links[after][first]
    half = np.float32(0.5)
    lowered = half * bend
    least = np.minimum(np.abs(step[first]), np.abs(step[last]))
    np.clip(lowered, -least, least, out=lowered)
    out[before] -= lowered * starts
    out[after] += lowered * ends
    if fine and heights.shape[axis] >= 5:
        both_sides = both[first][first] & both[last][last]
        third = bend[along(axis, 2, None)] - bend[along(axis, None, -2)]
        third *= np.float32(1 / 12)
        out[along(axis, 2, -2)] -= third * both_sides
    return out


def normals_of(
    heights: Float32, across: Mask, down: Mask, flat: Mask | None, *, fine: bool, factor: Float32 | None = None
) -> Float32:
    """Return the unit normals of heights, y up.

    Parameters
    ----------
    heights : (H, W) float32
        Heights in px.
    across, down : (H, W) bool
        Links to the next pixel to the right, and below.
    flat : (H, W) bool or None
        Where normals are (0, 0, 1), whatever the heights.
    fine : bool
        See `slope_along`.
    factor : (H, W) float32, optional
        Factor on the slopes.

    Returns
    -------
    (H, W, 3) float32
    """
    out = np.empty((*heights.shape, 3), np.float32)

    def work(tile: Tile) -> None:
        part = heights[tile.outer]
        right, below = across[tile.outer], down[tile.outer]
        if right.all() and below.all():  # inside the picture, without a jump
            kernel = _FINE if fine else _CENTRAL
            p = cv2.sepFilter2D(part, -1, kernel, _ONE)[tile.inner]
            q = cv2.sepFilter2D(part, -1, _ONE, kernel)[tile.inner]
        else:
            p = slope_along(part, right, 1, fine)[tile.inner]
            q = slope_along(part, below, 0, fine)[tile.inner]
        if factor is not None:
            p, q = p * factor[tile.core], q * factor[tile.core]
        if flat is not None:
            level = flat[tile.core]
            p[level] = 0
            q[level] = 0
        scale = p * p
        scale += q * q
        scale += np.float32(1)
        np.sqrt(scale, out=scale)
        np.divide(np.float32(1), scale, out=scale)
        p = np.float32(0) - p  # flat gives 0, not -0
        p *= scale
        q = q * scale  # rows run down: q is the negative slope
        q += np.float32(0)
        cv2.merge([p, q, scale], out[tile.core])

    for_tiles(heights.shape, _HALO, work)
    return out


def jump_sizes(heights: Float32, known: Mask, across: Mask, down: Mask) -> Float32:
    """Return (H, W) float32: the largest jump from each pixel to a known neighbour, 0 if there is none."""
    out = np.zeros_like(heights)
    for axis, links in ((0, down), (1, across)):
        cut = ~links[along(axis, None, -1)]
        cut &= known[along(axis, None, -1)]
        cut &= known[along(axis, 1, None)]
        first = places(cut)
        last = (first[0] + (axis == 0), first[1] + (axis == 1))
        size = np.abs(heights[last] - heights[first])
        for place in (first, last):  # neither contains a pixel twice
            out[place] = np.maximum(out[place], size)
    return out


def mean_curl(normals: Float32, mask: Mask) -> float:
    """Return the same as `nmaptool.core.vectors.mean_abs_curl`, computed in tiles."""
    sums: list[tuple[float, int]] = []

    def work(tile: Tile) -> None:
        # includes the vertices between this tile and the next ones
        rows, cols = (slice(part.start, part.stop + 1) for part in tile.core)
        count = int(np.count_nonzero(inner_vertices(mask[rows, cols])))
        if count:
            sums.append((count * mean_abs_curl(normals[rows, cols], mask[rows, cols]), count))

    for_tiles(mask.shape, 0, work)
    return sum(total for total, _ in sums) / max(sum(count for _, count in sums), 1)

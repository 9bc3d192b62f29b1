"""Fit a smooth surface to stepped or noisy heights: the one with the least bending within a tolerance of the heights.

A quantised height is known to half a step, so the best estimate is the surface with the least bending among all that
stay within half a step: a ramp becomes a ramp, whatever its steps, and features larger than the tolerance are kept.
Second differences never cross a jump. The fit starts on coarse grids, where a terrace of a hundred pixels is only a few
cells wide.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places
from nmaptool.depth.tiles import Tile, along, for_tiles

# descent steps on the pixels, and on each coarser grid
_ITERATIONS, _COARSE_ITERATIONS = 12, 32
# larger coarse grids get fewer steps, because they only give the start on the finer grid
_FULL_DESCENT_CELLS = 1e6
_LEAST_CELLS = 6
# 1 / (largest eigenvalue of the bending energy: 16 along each axis)
_PACE = np.float32(1 / 32)
# kernel of a descent step where all pixels are joined
_DESCENT = np.zeros((5, 5), np.float32)
_DESCENT[2] -= np.array([1, -4, 6, -4, 1]) * _PACE
_DESCENT[:, 2] -= np.array([1, -4, 6, -4, 1]) * _PACE
_DESCENT[2, 2] += 1
_EDGE = 2


def fit_surface(
    values: Float32,
    tolerance: Float32,
    across: Mask,
    down: Mask,
    iterations: int = _ITERATIONS,
    pixels: float | None = None,
) -> Float32:
    """Return the surface with the least bending within a tolerance of the values; broken links do not bend.

    Parameters
    ----------
    values : (H, W) float32
        Heights.
    tolerance : (H, W) float32
        How far the surface may leave the heights.
    across, down : (H, W) bool
        Whether a pixel is joined to the next one to the right, or below.
    iterations : int
        Descent steps on the pixels; a tolerance of several steps of the stored values needs more.
    pixels : float, optional
        Pixels of the whole picture, if this is a part of it; larger pictures get fewer steps.

    Returns
    -------
    (H, W) float32
    """
    start = None
    if min(values.shape) >= 2 * _LEAST_CELLS:
        start = _from_coarse(values, tolerance, across, down, values.size if pixels is None else pixels)
    out = np.empty_like(values)

    def work(tile: Tile) -> None:
        window = tile.outer
        if np.ptp(values[tile.core]) == 0 and np.ptp(values[window]) == 0:
            out[tile.core] = values[tile.core]
            return
        begin = values if start is None else start
        # no bending across the picture's edge: the padded pixels are not joined to any other
        around = [
            (_EDGE * (part.start == 0), _EDGE * (part.stop == side))
            for part, side in zip(window, values.shape, strict=True)
        ]
        middle = values[tile.core][0, 0]  # subtracted, since small numbers have smaller rounding errors
        fields = [np.pad(field[window], around, mode="edge") for field in (begin, values, tolerance)]
        fields[0] -= middle
        fields[1] -= middle
        right, below = (np.pad(link[window], around) for link in (across, down))
        fitted = _descend(fields[0], fields[1], fields[2], right, below, iterations)
        rows, cols = (
            slice(part.start + before, part.stop + before) for part, (before, _) in zip(tile.inner, around, strict=True)
        )
        np.add(fitted[rows, cols], middle, out=out[tile.core])

    for_tiles(values.shape, 2 * iterations, work)
    return out


def _from_coarse(values: Float32, tolerance: Float32, across: Mask, down: Mask, pixels: float) -> Float32:
    """Return the fit on cells of 2 x 2 pixels, extended linearly to the pixels and into cells that contain a jump."""
    rows, cols = (side // 2 * 2 for side in values.shape)
    x0, x1 = slice(0, cols, 2), slice(1, cols, 2)
    y0, y1 = slice(0, rows, 2), slice(1, rows, 2)
    whole = across[y0, x0] & across[y1, x0] & down[y0, x0] & down[y0, x1]
    mean, slack = (_mean_of_four(field, (y0, y1), (x0, x1)) for field in (values, tolerance))
    right = across[y0, x1] & across[y1, x1] & whole
    right[:, :-1] &= whole[:, 1:]
    right[:, -1] = False
    below = down[y1, x0] & down[y1, x1] & whole
    below[:-1] &= whole[1:]
    below[-1] = False
    cells = pixels / 4
    often = round(_COARSE_ITERATIONS * min(1.0, (_FULL_DESCENT_CELLS / cells) ** 0.5))
    coarse = fit_surface(mean, slack, right, below, max(often, _ITERATIONS), cells)
    quarter = np.float32(0.25)
    tilt_x, tilt_y = (linked_slope(coarse, links, axis) * quarter for axis, links in ((1, right), (0, below)))
    fine = values.copy()
    for (row, up), (col, left) in (((y0, -1), (x0, -1)), ((y0, -1), (x1, 1)), ((y1, 1), (x0, -1)), ((y1, 1), (x1, 1))):
        child = coarse + tilt_x if left > 0 else coarse - tilt_x
        child = child + tilt_y if up > 0 else child - tilt_y
        np.copyto(fine[row, col], child, where=whole)
    missing = np.ones(values.shape, bool)
    missing[:rows, :cols] = np.repeat(np.repeat(~whole, 2, axis=0), 2, axis=1)
    for _ in range(2):
        _continue_straight(fine, missing, across, down)
    return fine


def _continue_straight(surface: Float32, missing: Mask, across: Mask, down: Mask) -> None:
    """Extrapolate missing pixels linearly from two linked known ones, in place."""
    row, col = places(missing)
    total, count = np.zeros(len(row), np.float32), np.zeros(len(row), np.float32)
    for axis, links in ((0, down), (1, across)):
        for toward in (-1, 1):
            place, limit = (row, col)[axis], surface.shape[axis]
            near, far = (np.clip(place + toward * by, 0, limit - 1) for by in (1, 2))
            inside = (place + 2 * toward >= 0) & (place + 2 * toward < limit)
            first, second = ((near, col), (far, col)) if axis == 0 else ((row, near), (row, far))
            joined = (links[row, col] & links[first]) if toward > 0 else (links[first] & links[second])
            sound = inside & joined & ~missing[first] & ~missing[second]
            total += np.where(sound, 2 * surface[first] - surface[second], np.float32(0))
            count += sound
    found = count > 0
    surface[row[found], col[found]] = total[found] / count[found]
    missing[row[found], col[found]] = False


def _mean_of_four(field: Float32, rows: tuple[slice, slice], cols: tuple[slice, slice]) -> Float32:
    mean: Float32 = field[rows[0], cols[0]] + field[rows[0], cols[1]]
    mean += field[rows[1], cols[0]]
    mean += field[rows[1], cols[1]]
    mean *= np.float32(0.25)
    return mean


def linked_slope(values: Float32, links: Mask, axis: int) -> Float32:
    """Return (H, W) float32 differences along an axis: central, one-sided at a broken link, 0 between two of them."""
    first, last = along(axis, None, -1), along(axis, 1, None)
    step = (values[last] - values[first]) * links[first]
    total = np.zeros_like(values)
    count = np.zeros(values.shape, np.float32)
    total[first] += step
    total[last] += step
    count[first] += links[first]
    count[last] += links[first]
    np.maximum(count, np.float32(1), out=count)
    total /= count
    return total


def _descend(
    surface: Float32, values: Float32, tolerance: Float32, across: Mask, down: Mask, iterations: int
) -> Float32:
    """Minimise the bending energy by accelerated projected descent, starting at ``surface``."""
    low, high = values - tolerance, values + tolerance
    alone = ~(across | down)
    alone[:, 1:] &= ~across[:, :-1]
    alone[1:] &= ~down[:-1]
    cuts = [cut for cut in (_cut_bends(down, alone, 0), _cut_bends(across, alone, 1)) if cut is not None]
    surface = np.minimum(np.maximum(surface, low), high)
    moved, next_surface = surface.copy(), np.empty_like(surface)
    pace = 1.0
    for _ in range(iterations):
        bends = [_bend_at(moved, cut) for cut in cuts]
        cv2.filter2D(moved, -1, _DESCENT, next_surface, borderType=cv2.BORDER_REPLICATE)
        for cut, bend in zip(cuts, bends, strict=True):
            _give_back(next_surface, cut, bend)
        np.maximum(next_surface, low, out=next_surface)
        np.minimum(next_surface, high, out=next_surface)
        faster = (1 + (1 + 4 * pace * pace) ** 0.5) / 2
        push = (pace - 1) / faster
        cv2.addWeighted(next_surface, 1 + push, surface, -push, 0, moved)
        surface, next_surface, pace = next_surface, surface, faster
    return surface


def _cut_bends(links: Mask, alone: Mask, axis: int) -> tuple[NDArray[np.intp], int] | None:
    """Return the pixels whose second difference along an axis crosses a broken link, and the stride to neighbours."""
    before, middle, after = along(axis, None, -2), along(axis, 1, -1), along(axis, 2, None)
    broken = np.zeros(links.shape, bool)
    broken[middle] = ~(links[before] & links[middle])
    # it does not matter between pixels without any link
    broken[middle] &= ~(alone[before] & alone[middle] & alone[after])
    found = np.flatnonzero(broken)
    return (found, links.shape[1] if axis == 0 else 1) if len(found) else None


def _bend_at(surface: Float32, cut: tuple[NDArray[np.intp], int]) -> Float32:
    """Return the change that the descent makes for the bending at the cut pixels."""
    place, stride = cut
    flat = surface.reshape(-1)
    bend: Float32 = flat[place - stride] + flat[place + stride]
    bend -= 2 * flat[place]
    bend *= _PACE
    return bend


def _give_back(surface: Float32, cut: tuple[NDArray[np.intp], int], bend: Float32) -> None:
    """Undo the descent for the bending at the cut pixels, in place."""
    place, stride = cut
    flat = surface.reshape(-1)
    flat[place - stride] += bend
    flat[place + stride] += bend
    flat[place] -= 2 * bend

"""The pixels that lie well inside an exact outline."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_corners, touching_vertices
from nmaptool.core.winding import winding_on_grid

# distance of the pixels from the outline, and between the points of the outline that are looked at, in px
_CLEAR_PX = 0.25
_STEP_PX = 0.25
# a ring along a line of the grid passes through the pixels on both sides
_TOUCH_PX = 1e-6


def inner_mask(rings_px: Sequence[Float64], shape: tuple[int, int]) -> Mask:
    """The pixels inside rings that lie at least a quarter of a pixel from them and touch each other only at sides.

    Parameters
    ----------
    rings_px : sequence of (n, 2) float64
        x to the right and y down from the upper left corner of the picture; outer rings run counter-clockwise as seen.
    shape : (int, int)
        Rows and columns.

    Returns
    -------
    (H, W) bool

    Raises
    ------
    InputError
        If a ring winds around itself.
    """
    # between two points that are looked at, the outline lies at most half a step from one of them
    return joined_at_sides(inside_of(rings_px, shape) & ~pixels_near(rings_px, shape, _CLEAR_PX + _STEP_PX / 2))


def joined_at_sides(mask: Mask) -> Mask:
    """(H, W) bool: a mask without pixels that touch others at a corner only."""
    mask = mask.copy()
    while True:
        falling, rising = touching_corners(mask)
        if not (falling.any() or rising.any()):
            return mask
        mask[1:, 1:] &= ~falling
        mask[1:, :-1] &= ~rising


def pixels_over(rings_px: Sequence[Float64], shape: tuple[int, int]) -> Mask:
    """(H, W) bool: the pixels inside rings, and those that the rings pass through; otherwise as for `inner_mask`."""
    return inside_of(rings_px, shape) | pixels_near(rings_px, shape, _TOUCH_PX)


def vertices_between(rings_px: Sequence[Float64], inner: Mask) -> Mask:
    """(H+1, W+1) bool: vertices inside rings, not too near to them, that touch none of the pixels of a mask."""
    shape = inner.shape[0] + 1, inner.shape[1] + 1
    between = inside_of([ring + 0.5 for ring in rings_px], shape) & ~touching_vertices(inner)
    for ring in rings_px:
        points = _points_along(ring)
        nearest = np.rint(points)
        near = (np.abs(points - nearest) <= _CLEAR_PX + _STEP_PX / 2).all(axis=1)
        col, row = np.clip(nearest[near].astype(np.int64), 0, np.array(shape)[::-1] - 1).T
        between[row, col] = False
    return between


def inside_of(rings_px: Sequence[Float64], shape: tuple[int, int]) -> Mask:
    """(H, W) bool: the pixels whose centres lie inside; parameters and errors as for `inner_mask`."""
    rows, cols = (np.arange(0.5, count) for count in shape)
    winding = winding_on_grid(rings_px, cols, rows, side="right")
    if winding.max(initial=0) > 1 or winding.min(initial=0) < 0:
        raise InputError("the outline crosses itself; its rings must neither cross each other nor themselves")
    inside: Mask = winding > 0
    return inside


def pixels_near(rings_px: Sequence[Float64], shape: tuple[int, int], reach_px: float) -> Mask:
    """(H, W) bool: the pixels that points of the rings, a quarter of a pixel apart, come near to.

    Parameters
    ----------
    rings_px : sequence of (n, 2) float64
    shape : (int, int)
    reach_px : float
        Largest distance along x and along y from a pixel, at most 0.5; 0 for points in it.
    """
    near = np.zeros(shape, bool)
    for ring in rings_px:
        x, y = _points_along(ring).T
        for across in (-reach_px, reach_px):
            for down in (-reach_px, reach_px):
                col, row = np.floor(x + across).astype(np.int64), np.floor(y + down).astype(np.int64)
                found = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
                near[row[found], col[found]] = True
    return near


def _points_along(ring: Float64) -> Float64:
    """(n, 2): points of a ring, a quarter of a pixel apart or less."""
    way = np.roll(ring, -1, axis=0) - ring
    count = np.maximum(np.ceil(np.hypot(*way.T) / _STEP_PX).astype(np.int64), 1)
    edge = np.repeat(np.arange(len(ring)), count)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    points: Float64 = ring[edge] + (step / count[edge])[:, None] * way[edge]
    return points

"""Stepped or noisy heights to a smooth surface: the least bent one that stays within a tolerance of what is stored.

A quantised height is known to half a step, so that among all surfaces within half a step the least bent one is the
best guess: a ramp becomes a ramp, whatever its steps, and what stands out of the tolerance stays. Second differences
never cross a jump. Coarse grids first: a terrace of a hundred pixels is a matter of few cells there.
"""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float32, Mask
from nmaptool.depth.tiles import Tile, along, for_tiles

# steps of descent on the pixels, and on every coarser grid
_ITERATIONS, _COARSE_ITERATIONS = 10, 24
_LEAST_CELLS = 6
# 1 / (largest eigenvalue of the bending energy: 16 along each axis)
_DESCENT = np.float32(1 / 32)


def fit_surface(
    values: Float32, tolerance: Float32, across: Mask, down: Mask, iterations: int = _ITERATIONS
) -> Float32:
    """The least bent surface within a tolerance of the values, bending counted within whole links only.

    Parameters
    ----------
    values : (H, W) float32
        Heights.
    tolerance : (H, W) float32
        How far the surface may leave them.
    across, down : (H, W) bool
        Whether a pixel is joined to the next one to the right, or below.
    iterations : int
        Steps of descent on the pixels themselves; a tolerance of several steps of the stored values takes more.

    Returns
    -------
    (H, W) float32
    """
    start = None
    if min(values.shape) >= 2 * _LEAST_CELLS:
        start = _from_coarse(values, tolerance, across, down)
    out = np.empty_like(values)

    def work(tile: Tile) -> None:
        window = tile.outer
        surface = (values if start is None else start)[window].copy()
        fitted = _descend(surface, values[window], tolerance[window], across[window], down[window], iterations)
        out[tile.core] = fitted[tile.inner]

    for_tiles(values.shape, 2 * iterations, work)
    return out


def _from_coarse(values: Float32, tolerance: Float32, across: Mask, down: Mask) -> Float32:
    """The fit on cells of 2 x 2 pixels, continued straight to the pixels; cells that hold a jump keep their values."""
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
    coarse = fit_surface(mean, slack, right, below, _COARSE_ITERATIONS)
    quarter = np.float32(0.25)
    tilt_x, tilt_y = (linked_slope(coarse, links, axis) * quarter for axis, links in ((1, right), (0, below)))
    fine = values.copy()
    for (row, up), (col, left) in (((y0, -1), (x0, -1)), ((y0, -1), (x1, 1)), ((y1, 1), (x0, -1)), ((y1, 1), (x1, 1))):
        child = coarse + tilt_x if left > 0 else coarse - tilt_x
        child = child + tilt_y if up > 0 else child - tilt_y
        np.copyto(fine[row, col], child, where=whole)
    return fine


def _mean_of_four(field: Float32, rows: tuple[slice, slice], cols: tuple[slice, slice]) -> Float32:
    mean: Float32 = field[rows[0], cols[0]] + field[rows[0], cols[1]]
    mean += field[rows[1], cols[0]]
    mean += field[rows[1], cols[1]]
    mean *= np.float32(0.25)
    return mean


def linked_slope(values: Float32, links: Mask, axis: int) -> Float32:
    """(H, W) float32 difference along an axis: central, one-sided beside a broken link, 0 where both are broken."""
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
    """Accelerated projected descent of the bending energy, ``surface`` being where it starts."""
    low, high = values - tolerance, values + tolerance
    np.clip(surface, low, high, out=surface)
    bends = [_Bend(surface, links, axis) for axis, links in ((0, down), (1, across))]
    moved, gradient = surface.copy(), np.empty_like(surface)
    pace = 1.0
    for _ in range(iterations):
        gradient.fill(0)
        for bend in bends:
            bend.add_gradient(moved, gradient)
        gradient *= _DESCENT
        np.subtract(moved, gradient, out=gradient)
        np.maximum(gradient, low, out=gradient)
        np.minimum(gradient, high, out=gradient)
        faster = (1 + (1 + 4 * pace * pace) ** 0.5) / 2
        np.subtract(gradient, surface, out=moved)
        moved *= np.float32((pace - 1) / faster)
        moved += gradient
        surface, gradient, pace = gradient, surface, faster
    return surface


class _Bend:
    """Second differences along one axis, where both links are whole, and their adjoint."""

    def __init__(self, like: Float32, links: Mask, axis: int) -> None:
        self.axis = axis
        self.inside = along(axis, 1, -1)
        self.before, self.after = along(axis, None, -2), along(axis, 2, None)
        both = links[along(axis, None, -1)]
        self.weight = (both[along(axis, None, -1)] & both[along(axis, 1, None)]).astype(np.float32)
        self.bend = np.empty_like(self.weight)
        self.double = np.empty_like(self.weight)

    def add_gradient(self, surface: Float32, gradient: Float32) -> None:
        """Add half the energy's gradient."""
        bend, double = self.bend, self.double
        np.add(surface[self.before], surface[self.after], out=bend)
        np.add(surface[self.inside], surface[self.inside], out=double)
        bend -= double
        bend *= self.weight
        gradient[self.before] += bend
        gradient[self.after] += bend
        np.add(bend, bend, out=bend)
        gradient[self.inside] -= bend

"""Smoothing on the coarse levels: two Richardson steps before and two after, with step lengths after Chebyshev."""

from __future__ import annotations

import math

import numpy as np

import nmaptool.kernels.grid_twins as grid_twins
from nmaptool import kernels
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.finest import inner_product
from nmaptool.solver.multigrid.level import Stencil, in_bands, new_field

# the smoother damps modes whose eigenvalue is more than this share of the largest one
_LOWEST = 0.35
_POWER_STEPS = 5
_SAFETY = 1.15


class Relaxation:
    """Work space and steps of one level.

    Attributes
    ----------
    level : Stencil
    x : flat with margins
        The correction on the grid.
    off_grid : (count,)
        The correction at the off-grid vertices.
    """

    def __init__(self, level: Stencil) -> None:
        self.level = level
        self._loops = kernels if level.dtype == np.float32 else grid_twins
        self.x, self._next = new_field(level.shape, level.dtype), new_field(level.shape, level.dtype)
        self.off_grid = np.zeros(level.off_grid.count, level.dtype)
        self._load: Values = self.x
        self._load_strays: Values = self.off_grid
        top = min(2.0, _SAFETY * self._largest())
        middle, half = (1 + _LOWEST) / 2, (1 - _LOWEST) / 2 * math.cos(math.pi / 4)
        self._steps = (1 / (top * (middle + half)), 1 / (top * (middle - half)))

    def _largest(self) -> float:
        """Estimate the largest eigenvalue of the diagonally scaled matrix by the power method, from a fixed start."""
        level, random = self.level, np.random.default_rng(0)
        edge = level.edge
        self.x[edge : edge + level.size] = random.random(level.size) - 0.5
        self.x[edge : edge + level.size] *= level.inverse > 0
        self.off_grid = (random.random(level.off_grid.count) - 0.5).astype(level.dtype)
        self._load, self._load_strays = np.zeros(level.size, level.dtype), np.zeros(level.off_grid.count, level.dtype)
        size = 1.0
        for _ in range(_POWER_STEPS):
            size = self._size()
            if size == 0:
                return 1.0
            self.x /= size
            self.off_grid = self.off_grid / size
            before, strays_before = self.x, self.off_grid
            self._step(1.0)  # x - D^-1 A x; the old x is now the work space
            np.subtract(before, self.x, out=self.x)
            self.off_grid = strays_before - self.off_grid
        return self._size()

    def _size(self) -> float:
        """Return the Euclidean norm of the correction."""
        return math.sqrt(sum(inner_product(part, part) for part in (self.x, self.off_grid)))

    def load(self, residual: Values, off_grid: Values) -> None:
        """Set the right-hand side."""
        self._load, self._load_strays = residual, off_grid

    def smooth(self, first: bool) -> None:
        """Do two steps; the first ones start from zero, the last ones are in reverse order."""
        level = self.level
        one, two = self._steps
        if first:
            np.multiply(self._load, level.inverse, out=self.x[level.edge : level.edge + level.size])
            self.x *= one
            self.off_grid = self._load_strays * level.off_grid.inverse * one
            self._step(two)
        else:
            self._step(two)
            self._step(one)

    def _pull_of_off_grid(self) -> tuple[Values, Values] | None:
        off_grid, edge = self.level.off_grid, self.level.edge
        if not off_grid.count:
            return None
        from_grid = off_grid.from_grid.times(self.x[edge + off_grid.near])
        return off_grid.to_grid.times(self.off_grid), from_grid + off_grid.among.times(self.off_grid)

    def _step(self, length: float) -> None:
        """Replace x by x + length D^-1 (load - A x)."""
        level, edge, factor = self.level, self.level.edge, length
        x, out = self.x, self._next
        pulls = self._pull_of_off_grid()

        def band(start: int, stop: int) -> None:
            self._loops.coarse_step(
                *level.ordered, x, out, self._load, level.inverse, level.shape[1], start, stop, factor
            )

        in_bands(level.size, band)
        if pulls is not None:
            off_grid = level.off_grid
            out[edge + off_grid.near] += factor * level.inverse[off_grid.near] * pulls[0]
            self.off_grid = (1 - factor) * self.off_grid + factor * off_grid.inverse * (self._load_strays + pulls[1])
        self.x, self._next = out, x

    def left(self) -> tuple[Values, Values]:
        """Return the residual on the grid and at the off-grid vertices."""
        level, edge, x = self.level, self.level.edge, self.x
        left = self._next[edge : edge + level.size]  # free until the next step

        def band(start: int, stop: int) -> None:
            self._loops.coarse_left(*level.ordered, x, self._load, level.diagonal, left, level.shape[1], start, stop)

        in_bands(level.size, band)
        pulls = self._pull_of_off_grid()
        if pulls is None:
            return left, self._load_strays
        off_grid = level.off_grid
        left[off_grid.near] += pulls[0]
        return left, self._load_strays - off_grid.diagonal * self.off_grid + pulls[1]

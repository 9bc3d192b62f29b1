"""Parts of a system that share no face: each has its own residual, and its own null space where nothing holds it."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float64, Mask
from nmaptool.solver.system import QuadSystem

# a height weight this small beside the slopes' weights is lost in rounding when both are added up
_NO_TIE = 1e-11


class Islands:
    """Book-keeping of a system's islands.

    Attributes
    ----------
    count : int
    floating : (count+1,) bool
        Islands that neither held vertices nor a noticeable height weight tie: their shape is known up to a constant.
    anchors : (H+1, W+1) bool
        One vertex of each floating island, held at 0 while solving; the constant is settled by `center`.
    """

    def __init__(self, system: QuadSystem) -> None:
        self.labels, self.count = system.islands()
        flat = self.labels.ravel()
        self._beta = system.beta
        self._sizes = np.bincount(flat, minlength=self.count + 1)
        self._ties = self._sums(system.beta)
        loose = np.ones(self.count + 1, bool)
        loose[flat[system.held.ravel()]] = False
        loose[0] = False
        self._loose = loose  # nothing holds them
        self.floating = loose & (self._ties < _NO_TIE * self._sums(system.around))
        self.anchors: Mask = np.zeros(self.labels.shape, bool)
        if self.floating.any():
            label, first = np.unique(flat, return_index=True)
            self.anchors.flat[first[self.floating[label]]] = True

    def _sums(self, values: Float64) -> Float64:
        sums = np.bincount(self.labels.ravel(), values.ravel(), minlength=self.count + 1)
        return sums.astype(np.float64, copy=False)

    def norms(self, values: Float64) -> Float64:
        """(count+1,) Euclidean norm on each island."""
        if self.count == 1:
            return np.array([0.0, np.linalg.norm(values)])
        return np.sqrt(self._sums(values * values))

    def worst(self, residual: Float64, scale: Float64) -> float:
        """Largest residual relative to ``scale`` over the islands; 0 on islands whose load is 0."""
        norms = self.norms(residual)
        return float(np.max(np.divide(norms, scale, out=np.zeros_like(norms), where=scale > 0)))

    def only_lagging(self, residual: Float64, scale: Float64, tolerance: float) -> Float64:
        """The residual with islands that have converged set to 0."""
        if self.count == 1:
            return residual
        lagging = self.norms(residual) > tolerance * scale
        return np.where(lagging[self.labels], residual, 0.0)

    def level(self, load: Float64) -> Float64:
        """The constant that solves each island nothing holds on the whole: sum of beta z = sum of the load.

        Taken out first, it leaves a problem about shape alone, however small beta or large delta is.
        """
        tied = self._loose & (self._ties > 0)
        if not tied.any():
            return np.zeros(self.labels.shape)
        constant = np.divide(self._sums(load), self._ties, out=np.zeros(self.count + 1), where=tied)
        return np.asarray(constant[self.labels])

    def balance(self, load: Float64) -> Float64:
        """The load with its mean removed on floating islands, where only that part can be met."""
        if not self.floating.any():
            return load
        mean = np.where(self.floating, self._sums(load) / np.maximum(self._sizes, 1), 0.0)
        return load - mean[self.labels]

    def center(self, z: Float64, load: Float64) -> Float64:
        """Heights of floating islands shifted: to meet the height term where there is one, else to mean 0."""
        if not self.floating.any():
            return z
        tied = self._ties > 0
        needed = np.where(tied, self._sums(load) - self._sums(self._beta * z), -self._sums(z))
        shift = needed / np.where(tied, self._ties, np.maximum(self._sizes, 1))
        return z + np.where(self.floating, shift, 0.0)[self.labels]

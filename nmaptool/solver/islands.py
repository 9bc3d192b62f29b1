"""Parts of a system that share no face: each has its own residual, and its own null space where nothing holds it."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float64, Mask
from nmaptool.solver.system import QuadSystem


class Islands:
    """Book-keeping of a system's islands.

    Attributes
    ----------
    count : int
    floating : (count+1,) bool
        Islands with neither a held vertex nor any height weight: their heights are known up to a constant.
    anchors : (H+1, W+1) bool
        One vertex of each floating island, held at 0 while solving; the constant is settled by `center`.
    """

    def __init__(self, system: QuadSystem) -> None:
        self.labels, self.count = system.islands()
        flat = self.labels.ravel()
        self._unknown = system.unknown.ravel()
        tied = np.zeros(self.count + 1, bool)
        tied[flat[(system.held | (system.beta > 0)).ravel()]] = True
        tied[0] = True
        self.floating = ~tied
        self.anchors: Mask = np.zeros(self.labels.shape, bool)
        if self.floating.any():
            label, first = np.unique(flat, return_index=True)
            self.anchors.flat[first[self.floating[label]]] = True
            self._sizes = np.bincount(flat, minlength=self.count + 1)

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

    def _without_mean(self, values: Float64) -> Float64:
        if not self.floating.any():
            return values
        mean = np.where(self.floating, self._sums(values) / np.maximum(self._sizes, 1), 0.0)
        return values - mean[self.labels]

    def balance(self, load: Float64) -> Float64:
        """The load with its mean removed on floating islands, where only that part can be met."""
        return self._without_mean(load)

    def center(self, z: Float64) -> Float64:
        """Heights with mean 0 on floating islands."""
        return self._without_mean(z)

"""Islands: parts of a system without a common vertex. Each has its own residual, and a free constant if not held."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.solver.runs import Runs
from nmaptool.solver.system import QuadSystem, See

# a height weight this small compared to the weights of the slopes is lost in rounding when they are added
_NO_TIE = 1e-11
# below this, the residual hardly depends on the mean height of an island
_WEAK_TIE = 1e-6


@dataclass(frozen=True, eq=False)
class Constants:
    """Constants of the islands without held vertices, known before their shapes are solved.

    Attributes
    ----------
    level : (count+1,) float64 or None
        The constant that solves each island in sum: sum of beta z = sum of the load. Subtracting it first leaves a
        problem of shape alone, however small beta or large delta is. None if all are 0.
    mean : (count+1,) float64 or None
        Mean of the remaining load on floating islands, which no heights can match. None if all are 0.
    """

    level: Float64 | None
    mean: Float64 | None


class Islands:
    """The islands of a system, and sums, norms and constants on them.

    Parameters
    ----------
    system : QuadSystem
    like : Islands, optional
        Those of a system in which the same faces have a weight and the same vertices are held.

    Attributes
    ----------
    count : int
    floating : (count+1,) bool
        Islands with neither held vertices nor a noticeable height weight: their heights are known up to a constant.
        Index 0 is for vertices outside every island and never floats.
    """

    def __init__(self, system: QuadSystem, like: Islands | None = None) -> None:
        self._system = system
        if like is None:
            self._faces, self.count = system.faces()
            # islands without held vertices; a single island that is held entirely does not float
            self._loose = self._find_loose()
            if self.count > 1:
                _ = self._runs
        else:
            self._faces, self.count, self._loose = like._faces, like.count, like._loose
            if "_runs" in vars(like):
                self._runs = like._runs
        self._ties = np.zeros(self.count + 1)
        self.floating: Mask = np.zeros(self.count + 1, bool)
        self._weak = self.floating
        if self._loose.any():
            operator, beta = system.operator, system.beta
            self._ties = self._runs.sums(lambda band: beta[band].reshape(-1).astype(np.float64, copy=False))
            self._sizes = np.maximum(self._runs.total(self._runs.lengths.astype(np.float64)), 1)
            stiffness = 4 * system.weight_range[1] * self._sizes  # at most
            if (self._loose & (self._ties > 0) & (self._ties < _NO_TIE * stiffness)).any():
                stiffness = self._runs.sums(lambda band: operator.around(band).reshape(-1))
            self.floating = self._loose & (self._ties < _NO_TIE * stiffness)
            self._weak = self._loose & (self._ties < _WEAK_TIE * stiffness)

    @functools.cached_property
    def _runs(self) -> Runs:
        runs = Runs(self._faces, self.count)
        self._faces = np.zeros((0, 0), bool)  # the runs replace them
        return runs

    def _find_loose(self) -> Mask:
        """Return (count+1,) bool: islands without a held vertex."""
        held = self._system.held
        if self.count == 1:
            return np.array([False, not (held.any() and (held & touching_vertices(self._faces != 0)).any())])
        loose = np.ones(self.count + 1, bool)
        if held.any():
            loose = self._runs.sums(lambda band: held[band].reshape(-1).astype(np.float64)) == 0
        loose[0] = False
        return loose

    @property
    def labels(self) -> NDArray[np.int32]:
        """(H+1, W+1) island of each vertex, 0 for none; recomputed on every access."""
        return self._runs.map()

    @property
    def anchors(self) -> Mask:
        """(H+1, W+1) bool: one vertex of each floating island, to leave out of an assembled matrix.

        Its height is then 0; `center` sets the constant.
        """
        out = np.zeros(self._system.beta.shape, bool)
        if self.floating.any():
            out.flat[self._runs.firsts()[self.floating]] = True
        return out

    def residual(
        self, load: Float64, z: Float64 | None, out: NDArray[Any] | None, constants: Constants | None = None
    ) -> Float64:
        """Write load - A z to ``out`` as `QuadSystem.residual` does.

        Parameters
        ----------
        load, z, out
            As for `QuadSystem.residual`; ``out`` is required if constants are given and an island floats.
        constants : Constants, optional
            Their part of the load is subtracted. The residual of floating islands then has mean 0, because no heights
            can change its mean.

        Returns
        -------
        (count+1,) float64
            Euclidean norm of the residual on each island.
        """
        system = self._system
        less = None if constants is None else self._less(constants)
        balanced = constants is not None and bool(self.floating.any())
        if self.count == 1 and not balanced:
            return np.array([0.0, system.residual(load, z, out, less=less)])
        runs, found = self._runs, np.empty(len(self._runs.labels))

        def squares(band: slice, left: Float64) -> None:
            found[runs.of(band)] = runs.add(band, left * left)

        def plain(band: slice, left: Float64) -> None:
            found[runs.of(band)] = runs.add(band, left)

        if not balanced:
            system.residual(load, z, out, less=less, see=squares)
            return self._norms(found)
        assert out is not None
        system.residual(load, z, out, less=less, see=plain)
        # almost 0 by now: rounding, and the effect of a height term too small to count
        mean = np.where(self.floating, runs.total(found) / self._sizes, 0.0)

        def balance(band: slice) -> None:
            left = out[band].reshape(-1)
            left -= runs.spread(band, mean)
            squares(band, left.astype(np.float64, copy=False))

        runs.each(balance)
        return self._norms(found)

    def _less(self, constants: Constants) -> See | None:
        """Return a function that subtracts beta * level and the mean from a band."""
        if constants.level is None and constants.mean is None:
            return None
        runs, beta = self._runs, self._system.beta

        def take(band: slice, left: Float64) -> None:
            if constants.level is not None:
                left -= beta[band].reshape(-1) * runs.spread(band, constants.level)
            if constants.mean is not None:
                left -= runs.spread(band, constants.mean)

        return take

    def _norms(self, squares: Float64) -> Float64:
        """Return the (count+1,) norms from the sums of squares of the runs.

        The norm of a single island includes the vertices outside it.
        """
        found = self._runs.total(squares)
        if self.count == 1:
            found = np.array([0.0, found.sum()])
        return np.asarray(np.sqrt(found))

    def keep(self, which: Mask, out: NDArray[Any]) -> None:
        """Set ``out`` to 0 on all islands except those in ``which`` (count+1,)."""
        if which.all() or (self.count == 1 and which[1]):
            return
        runs = self._runs

        def clear(band: slice) -> None:
            out[band].reshape(-1)[~runs.spread(band, which)] = 0

        runs.each(clear)

    def constants(self, load: Float64) -> Constants:
        """Return the level of each island without held vertices, and the mean remaining load of floating islands."""
        if not self._loose.any():
            return Constants(None, None)
        runs, beta = self._runs, self._system.beta
        tied = self._loose & (self._ties > 0)
        sums = runs.sums(lambda band: load[band].reshape(-1))
        level = np.divide(sums, self._ties, out=np.zeros(self.count + 1), where=tied)
        mean = np.zeros(self.count + 1)
        if self.floating.any():
            shape = runs.sums(lambda band: load[band].reshape(-1) - beta[band].reshape(-1) * runs.spread(band, level))
            mean = np.where(self.floating, shape / self._sizes, 0.0)
        return Constants(level if level.any() else None, mean if mean.any() else None)

    def add(self, z: Float64, of_islands: Float64 | None) -> None:
        """Add a constant to each island of ``z``, in place."""
        if of_islands is None:
            return
        runs = self._runs

        def work(band: slice) -> None:
            here = z[band].reshape(-1)
            here += runs.spread(band, of_islands)

        runs.each(work)

    def center(self, z: Float64) -> None:
        """Shift floating and weakly tied islands in place: to satisfy the height term in sum, or to mean 0 without one.

        The exact solution of an island without held vertices satisfies the height term in sum, however small beta is.

        Parameters
        ----------
        z : (H+1, W+1) float64
            Heights without the levels of the islands.
        """
        if not self._weak.any():
            return
        runs, beta = self._runs, self._system.beta
        tied = self._ties > 0
        shift = np.zeros(self.count + 1)
        if (self._weak & ~tied).any():
            shift = runs.sums(lambda band: z[band].reshape(-1)) / self._sizes
        if (self._weak & tied).any():
            pulled = runs.sums(lambda band: (beta[band] * z[band]).reshape(-1))
            shift = np.where(tied, pulled / np.where(tied, self._ties, 1), shift)
        self.add(z, np.where(self._weak, -shift, 0.0))

"""Parts of a system that share no face: each has its own residual, and its own null space where nothing holds it."""

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

# a height weight this small beside the slopes' weights is lost in rounding when both are added up
_NO_TIE = 1e-11
# with one below this a residual hardly tells how high an island lies
_WEAK_TIE = 1e-6


@dataclass(frozen=True, eq=False)
class Constants:
    """What is known of the islands that nothing holds, before their shapes are.

    Attributes
    ----------
    level : (count+1,) float64 or None
        The constant that solves each of them on the whole: sum of beta z = sum of the load. Taken out first, it leaves
        a problem about shape alone, however small beta or large delta is. None where all are 0.
    mean : (count+1,) float64 or None
        Mean of the rest of the load on floating islands, where it cannot be met. None where all are 0.
    """

    level: Float64 | None
    mean: Float64 | None


class Islands:
    """Book-keeping of a system's islands.

    Attributes
    ----------
    count : int
    floating : (count+1,) bool
        Islands that neither held vertices nor a noticeable height weight tie: their shape is known up to a constant.
        Number 0 stands for the vertices of no island and never floats.
    """

    def __init__(self, system: QuadSystem) -> None:
        self._system = system
        self._faces, self.count = system.faces()
        # nothing holds them; one island of which all is held is none that floats
        self._loose = self._find_loose()
        if self.count > 1:
            _ = self._runs
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
        self._faces = np.zeros((0, 0), bool)  # they say it all
        return runs

    def _find_loose(self) -> Mask:
        """(count+1,) bool: islands without a held vertex."""
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
        """(H+1, W+1) island of each vertex, 0 for none; computed on every access."""
        return self._runs.map()

    @property
    def anchors(self) -> Mask:
        """(H+1, W+1) bool: one vertex of each floating island, to be left out of a matrix that is factored.

        Its height is 0 then; the constant is settled by `center`.
        """
        out = np.zeros(self._system.beta.shape, bool)
        if self.floating.any():
            out.flat[self._runs.firsts()[self.floating]] = True
        return out

    def residual(
        self, load: Float64, z: Float64 | None, out: NDArray[Any] | None, constants: Constants | None = None
    ) -> Float64:
        """Put load - A z into ``out`` as `QuadSystem.residual` does.

        Parameters
        ----------
        load, z, out
            As there; where an island floats and there are constants, ``out`` is needed.
        constants : Constants, optional
            What is taken off; floating islands then have mean 0, since only that part can be met.

        Returns
        -------
        (count+1,) float64
            Its Euclidean norm on each island.
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
        # next to nothing by now: rounding, and what a height term does that is lost in it
        mean = np.where(self.floating, runs.total(found) / self._sizes, 0.0)

        def balance(band: slice) -> None:
            left = out[band].reshape(-1)
            left -= runs.spread(band, mean)
            squares(band, left.astype(np.float64, copy=False))

        runs.each(balance)
        return self._norms(found)

    def _less(self, constants: Constants) -> See | None:
        """Takes beta * level and the mean off a band."""
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
        """(count+1,) norms from the sums of squares of runs; one island's counts the vertices of none, too."""
        found = self._runs.total(squares)
        if self.count == 1:
            found = np.array([0.0, found.sum()])
        return np.asarray(np.sqrt(found))

    def keep(self, which: Mask, out: NDArray[Any]) -> None:
        """Set ``out`` to 0 on all islands but those of ``which`` (count+1,)."""
        if which.all() or (self.count == 1 and which[1]):
            return
        runs = self._runs

        def clear(band: slice) -> None:
            out[band].reshape(-1)[~runs.spread(band, which)] = 0

        runs.each(clear)

    def constants(self, load: Float64) -> Constants:
        """The level of each island nothing holds, and the mean of what is left of the load on floating islands."""
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
        """Shift floating and weakly tied islands in place: to meet the height term if there is one, else to mean 0.

        What solves an island that nothing holds meets the height term on the whole, however small beta is.

        Parameters
        ----------
        z : (H+1, W+1) float64
            Without the islands' levels.
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

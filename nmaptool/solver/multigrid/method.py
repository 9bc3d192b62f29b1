"""Conjugate gradients in float32, preconditioned by a V-cycle; the heights are float64."""

from __future__ import annotations

import math
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nmaptool.kernels.transfer_twins as transfer_twins
from nmaptool import kernels
from nmaptool.core.arrays import Float64
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.method import Report
from nmaptool.solver.multigrid.hierarchy import Hierarchy
from nmaptool.solver.multigrid.level import new_field
from nmaptool.solver.system import QuadSystem

# down to this reduction the updated residual matches the heights; below it, it must be recomputed
_REDUCTION: dict[type[np.floating[Any]], float] = {np.float32: 4e-7, np.float64: 1e-13}
# coarse levels are reused if the ratios of new to old weights differ by at most this factor
_MOST_CHANGE = 2.0
_PATIENCE = 12


def _factor(made_for: QuadSystem, system: QuadSystem) -> float | None:
    """Return the ratio of the weights to the old ones, or None if it varies too much or other vertices are held."""
    if made_for.weight.shape != system.weight.shape or not np.array_equal(made_for.held, system.held):
        return None
    least, most = math.inf, 0.0
    for old, new in ((made_for.weight, system.weight), (made_for.beta, system.beta)):
        if new is old:
            least, most = min(least, 1.0), max(most, 1.0)
            continue
        acting = old > 0
        if not np.array_equal(acting, new > 0):
            return None
        if not acting.any():
            continue
        first = acting.argmax()
        # elsewhere, a ratio that occurs: reductions with a mask are slow
        ratios = np.full(old.shape, new.flat[first] / old.flat[first], np.float32)
        np.divide(new, old, out=ratios, where=acting)
        least, most = min(least, float(ratios.min())), max(most, float(ratios.max()))
    return math.sqrt(least * most) if most <= _MOST_CHANGE * least else None


def _stalls(history: list[float]) -> bool:
    """Whether the last iterations did not even halve the residual: the rest is rounding error."""
    return len(history) > _PATIENCE and min(history[-_PATIENCE:]) > 0.5 * min(history[:-_PATIENCE])


class MultigridMethod:
    """One hierarchy for any number of right-hand sides; see `nmaptool.solver.method.Method`.

    Parameters
    ----------
    system : QuadSystem
    like : MultigridMethod, optional
        Method of another system. If the two systems differ little, its coarse levels are reused, which saves most of
        the set-up.

    Attributes
    ----------
    borrowed : bool
        Whether the coarse levels are those of ``like``.
    """

    name = "multigrid"

    def __init__(self, system: QuadSystem, like: MultigridMethod | None = None) -> None:
        self.precision: type[np.floating[Any]] = np.float64 if system.has_wide_weights else np.float32
        self._floor = _REDUCTION[self.precision]
        factor = None if like is None or like.precision != self.precision else _factor(like._made_for, system)
        self.borrowed = factor is not None
        if like is not None and factor is not None:
            self._hierarchy: Hierarchy = like._hierarchy.under(system, factor)
            self._made_for: QuadSystem = like._made_for
            self._one_at_a_time: threading.Lock = like._one_at_a_time
        else:
            self._hierarchy, self._made_for = Hierarchy(system, self.precision), system
            self._one_at_a_time = threading.Lock()  # the levels share one work space

    def improve(
        self, z: Float64, residual: NDArray[Any], reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """Solve by conjugate gradients from zero."""
        finest = self._hierarchy.finest
        left = residual.reshape(-1)
        size = float(max(left.max(), -left.min()))
        if size == 0:
            return (0.0,)
        left /= size
        start = math.sqrt(finest.dot(left, left))
        history: list[float] = []
        with self._one_at_a_time:
            search = _Search(self._hierarchy, left)
            while len(history) < max_iterations:
                rest = search.step(z.reshape(-1), size)
                if rest is None:
                    break  # the rest is rounding error
                history.append(math.sqrt(rest) / start)
                if report is not None:
                    report(history[-1])
                if not history[-1] > max(reduction, self._floor) or _stalls(history):
                    break
        return tuple(history) or (1.0,)


class _Search:
    """State of the conjugate gradients: one residual, one direction.

    Parameters
    ----------
    hierarchy : Hierarchy
    left : flat
        The residual; updated in place.
    """

    def __init__(self, hierarchy: Hierarchy, left: Values) -> None:
        self._hierarchy, self._left = hierarchy, left
        finest = hierarchy.finest
        self._direction = new_field(finest.shape, finest.dtype)
        # the result of a cycle, then A times the direction
        self._other = np.empty(finest.size, finest.dtype)
        self._before = math.inf

    def step(self, z: Float64, size: float) -> float | None:
        """Do one step; return the squared norm of the residual, or None if rounding errors dominate.

        Parameters
        ----------
        z : flat float64
            Heights; ``size`` times the step is added to them.
        size : float
        """
        finest, left, other = self._hierarchy.finest, self._left, self._other
        loops: Any = kernels if finest.dtype == np.float32 else transfer_twins
        direction = self._direction
        product = self._hierarchy.cycle(left, other)
        turn = product / self._before
        self._before = product
        curvature = finest.advance(direction, other, turn)
        if not (product > 0 and curvature > 0):
            return None
        length = product / curvature

        def move(first: int, last: int) -> float:
            norm2: float = loops.move(direction, other, z, left, length, size, first, last, finest.edge)
            return norm2

        return finest.sum_over_bands(move)

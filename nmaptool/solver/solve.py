"""The loop around every method: compute a float64 residual, correct, and repeat until each island is in tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import ConvergenceError, InputError
from nmaptool.core.progress import Progress
from nmaptool.solver.islands import Islands
from nmaptool.solver.memory import kind_of, plan
from nmaptool.solver.method import DirectMethod, Method, Report
from nmaptool.solver.system import QuadSystem, extremes
from nmaptool.solver.window import Window

# a load this small compared to its level is rounding error
_ROUNDING = 1e-15
# loads outside this range are scaled before the solve
_LEAST, _MOST = 1e-12, 1e12
_NOT_FINITE = "the right-hand side holds NaN or infinite values"


@dataclass(frozen=True, eq=False)
class Solution:
    """Heights and how well they solve the system.

    Attributes
    ----------
    z : (H+1, W+1) float64
        Heights; 0 at vertices outside every island. An island that nothing holds has mean 0.
    residual : float
        Largest relative residual |load - A z| / |load| over the islands, from the matrix-free operator.
    iterations : int
    history : tuple of float
        Relative residual after each iteration, as estimated by the method; the last value of each pass is measured.
    """

    z: Float64
    residual: float
    iterations: int
    history: tuple[float, ...]


class Solver:
    """A prepared system that solves for any number of right-hand sides.

    Parameters
    ----------
    window : Window
        The part of the picture with unknown vertices.
    system : QuadSystem
        The system of that part.
    method : Method
    islands : Islands
    planned_bytes : int
        Estimated memory of a solve, see `nmaptool.solver.memory`; 0 if it was not estimated.
    """

    def __init__(
        self, window: Window, system: QuadSystem, method: Method, islands: Islands, planned_bytes: int = 0
    ) -> None:
        self.window = window
        self.system = system
        self.method = method
        self.islands = islands
        self.planned_bytes = planned_bytes
        self.unknowns = int(np.count_nonzero(system.unknown))

    def check_memory(self, limit_bytes: int | None) -> None:
        """Check that this solver would have been allowed under a memory limit.

        Raises
        ------
        LimitError
            If its estimated memory exceeds the limit.
        """
        if limit_bytes is not None:
            plan(
                self.system.weight.shape,
                self.unknowns,
                kind_of(self.method.name, self.system.has_wide_weights),
                limit_bytes,
            )

    def solve(
        self,
        load: Float64,
        held_z: Float64 | None = None,
        *,
        start: Float64 | None = None,
        tolerance: float = 1e-8,
        max_iterations: int = 100,
        progress: Progress | None = None,
    ) -> Solution:
        """Solve for one right-hand side.

        Parameters
        ----------
        load : (H+1, W+1) float64
            Right-hand side g + beta delta.
        held_z : (H+1, W+1) float64, optional
            Heights of the held vertices; default 0.
        start : (H+1, W+1) float64, optional
            Heights to start from, such as those of a similar right-hand side. They change only the time of the solve.
        tolerance : float
            Relative residual to reach on every island.
        max_iterations : int
        progress : callable, optional
            Called with the name of the stage and the share done, 0 to 1.

        Raises
        ------
        InputError
            If the load, a held height or the start is not finite or has the wrong shape.
        ConvergenceError
            If the tolerance is not reached; the error holds the history.
        """
        direct = self.method if start is None and isinstance(self.method, DirectMethod) else None
        self._check(load, held_z, start)
        cut = self.window.cut
        held_here = None if held_z is None else cut(held_z)
        on_the_way = _Solve(self, np.ascontiguousarray(cut(load), np.float64), held_here, in_place=direct is not None)
        report = _Report(progress, tolerance)
        history: list[float] = []
        if direct is not None and on_the_way.scale.any():
            relative = on_the_way.answer(direct)
            history.append(float(relative.max()))
        else:
            relative = on_the_way.begin(None if start is None else cut(start))
        # usually one pass is enough; further passes are needed at the limit of a method's precision, or if islands much
        # smaller than the rest converge more slowly than the common norm
        while relative.max() > tolerance and len(history) < max_iterations:
            lagging, before = relative > tolerance, relative
            asked = 0.8 * tolerance, max_iterations - len(history)
            relative, seen = on_the_way.improve(relative, lagging, *asked, report)
            history += seen
            if not (relative[lagging] < before[lagging] / 2).any():
                break
        worst = float(relative.max())
        if not worst <= tolerance:
            raise ConvergenceError(
                f"the {self.method.name} solver stopped at a relative residual of {worst:.1e} after {len(history)} "
                f"iterations, but the tolerance is {tolerance:.0e}; raise `max_iterations` or `tolerance`, or use a "
                f"larger `beta` (history: {' '.join(f'{r:.1e}' for r in history[-8:])})",
                tuple(history),
            )
        report(0.0)
        return Solution(self.window.place(on_the_way.finished(), held_z), worst, len(history), tuple(history))

    def _check(self, load: Float64, held_z: Float64 | None, start: Float64 | None) -> None:
        held = self.window.held
        for name, given in (("right-hand side", load), ("held heights", held_z), ("start heights", start)):
            if given is not None and given.shape != held.shape:
                raise InputError(f"the {name} must be of shape {held.shape}, found {given.shape}")
        if start is not None and not _is_finite(start):
            raise InputError("the start heights must be finite; found NaN or infinite values")
        # nothing else looks outside the window
        if not (
            self.window.is_whole or (_is_finite(load) and (held_z is None or _is_finite(np.where(held, held_z, 0))))
        ):
            raise InputError(_NOT_FINITE)


def _is_finite(values: NDArray[Any]) -> bool:
    return bool(np.isfinite(extremes(values)).all())


class _Solve:
    """State of the solve for one right-hand side: the heights without the constants of their islands, and the residual.

    The slopes of a constant are zero, so a level changes the load by beta * level only.
    """

    def __init__(self, solver: Solver, load: Float64, held_z: Float64 | None, in_place: bool) -> None:
        self._system, self._method, self._islands = solver.system, solver.method, solver.islands
        held = self._system.held
        self._z = np.zeros(held.shape)
        if held_z is not None:
            np.copyto(self._z, held_z, where=held)
        size = float(np.abs([*extremes(load), *(() if held_z is None else extremes(self._z))]).max())
        if not np.isfinite(size):
            raise InputError(_NOT_FINITE)
        self._flat = held_z is None or not self._z.any()
        # squares in float32 overflow above 1e19; scaling by a power of two is exact
        self._unit = 1.0 if size == 0 or _LEAST < size < _MOST else 2.0 ** math.frexp(size)[1]
        self._load = load if self._unit == 1 else load / self._unit
        if self._unit != 1:
            self._z /= self._unit
        self._left: NDArray[Any] | None = None
        left = None if in_place else self._room()
        self.scale = self._islands.residual(self._load, None if self._flat else self._z, left)
        self._constants = self._islands.constants(self._load)
        if self._constants.level is not None:
            self._scale_by_shape(left)

    def _scale_by_shape(self, left: NDArray[Any] | None) -> None:
        """Measure residuals relative to the load without the level, however large the level is."""
        flat = None if self._flat else self._z
        shape = self._islands.residual(self._load, flat, self._room() if left is None else left, self._constants)
        self.scale = np.where(shape > _ROUNDING * self.scale, shape, 0.0)

    def answer(self, method: DirectMethod) -> Float64:
        """Solve in place and return the relative residual of each island."""
        self._islands.residual(self._load, None, self._z, self._constants)
        method.answer(self._z)
        self._flat = False
        if not self._islands.floating.any():
            return self._relative(None)
        self._islands.center(self._z)
        return self._relative(self._room())

    def begin(self, start: Float64 | None) -> Float64:
        """Begin with earlier heights, if there are any, and return the relative residual of each island."""
        if start is not None:
            self._put(start)
        elif self._left is not None and (self._constants.level is not None or self._constants.mean is None):
            return (self.scale > 0).astype(np.float64)  # the scale is the norm of the same residual
        return self._relative(self._room())

    def improve(
        self, relative: Float64, lagging: Mask, tolerance: float, max_iterations: int, report: _Report
    ) -> tuple[Float64, list[float]]:
        """Do one pass on the lagging islands; return each island's relative residual and the history of the pass."""
        share = float(relative.max())
        if self._left is None:  # only its norms were needed before
            self._relative(self._room())
        left = self._room()
        self._islands.keep(lagging, left)
        seen = self._method.improve(self._z, left, tolerance / share, max_iterations, report.times(share))
        self._islands.center(self._z)
        self._flat = False
        now = self._relative(left)
        return now, [*(each * share for each in seen[:-1]), float(now.max())]

    def finished(self) -> Float64:
        """Return the heights with their constants."""
        self._left = None
        self._islands.add(self._z, self._constants.level)
        if self._unit != 1:
            self._z *= self._unit
        return self._z

    def _room(self) -> NDArray[Any]:
        if self._left is None:
            self._left = np.empty(self._z.shape, self._method.precision)
        return self._left

    def _relative(self, left: NDArray[Any] | None) -> Float64:
        """Return the (count+1,) residual relative to the load; 0 on islands whose load is 0."""
        norms = self._islands.residual(self._load, None if self._flat else self._z, left, self._constants)
        return np.divide(norms, self.scale, out=np.zeros_like(norms), where=self.scale > 0)

    def _put(self, start: Float64) -> None:
        """Set the unknown vertices to the start heights minus their level; 0 on islands without a load."""
        z, system, islands = self._z, self._system, self._islands
        np.divide(start, self._unit, out=z, where=system.unknown)
        if self._constants.level is not None:  # 0 on islands that are held: those heights stay
            islands.add(z, -self._constants.level)
        silent = self.scale == 0
        silent[0] &= islands.count > 1  # the norm of a single island includes the vertices outside it
        if silent.any():
            z[system.unknown & silent[islands.labels]] = 0
        islands.center(z)
        self._flat = False


class _Report:
    """Reports progress computed from residuals; it never goes backwards."""

    def __init__(self, progress: Progress | None, tolerance: float) -> None:
        self._progress = progress
        self._asked = math.log(tolerance)
        self._shown = 0.0

    def __call__(self, relative: float) -> None:
        """Report the share done at this residual, on a logarithmic scale."""
        if self._progress is not None:
            share = math.log(min(max(relative, 1e-300), 1.0)) / self._asked
            self._shown = min(max(share, self._shown), 1.0)
            self._progress("solving", self._shown)

    def times(self, share: float) -> Report | None:
        """Return the same report for residuals relative to ``share`` times the load."""
        return None if self._progress is None else lambda relative: self(relative * share)

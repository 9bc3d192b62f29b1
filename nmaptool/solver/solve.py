"""The loop around every method: a float64 residual, a correction, again until each island is within tolerance."""

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

# loads of another size are solved in another unit
# a load this small beside its level is rounding
_ROUNDING = 1e-15
_LEAST, _MOST = 1e-12, 1e12


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
        Relative residual after each iteration, as the solver saw it; measured where a method was done.
    """

    z: Float64
    residual: float
    iterations: int
    history: tuple[float, ...]


class Solver:
    """A prepared system: one set-up, any number of right-hand sides.

    Parameters
    ----------
    system : QuadSystem
    method : Method
    islands : Islands
    planned_bytes : int
        Memory that a solve was reckoned to take, see `nmaptool.solver.memory`; 0 where nobody did.
    """

    def __init__(self, system: QuadSystem, method: Method, islands: Islands, planned_bytes: int = 0) -> None:
        self.system = system
        self.method = method
        self.islands = islands
        self.planned_bytes = planned_bytes
        self.unknowns = int(np.count_nonzero(system.unknown))

    def check_memory(self, limit_bytes: int | None) -> None:
        """Refuse a limit that the solver, which is there already, would not have been made under.

        Raises
        ------
        LimitError
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
            Heights to start from, such as those of a similar right-hand side. Time depends on them, and nothing else.
        tolerance : float
            Relative residual to reach on every island.
        max_iterations : int
        progress : callable, optional
            Called with a word and a share in 0..1.

        Raises
        ------
        InputError
            If the load, a held height or the start is not finite or of another shape.
        ConvergenceError
            If the tolerance is not reached; the history is in the error.
        """
        direct = self.method if start is None and isinstance(self.method, DirectMethod) else None
        on_the_way = _Solve(self, np.ascontiguousarray(load, np.float64), held_z, in_place=direct is not None)
        report = _Report(progress, tolerance)
        history: list[float] = []
        if direct is not None and on_the_way.scale.any():
            relative = on_the_way.answer(direct)
            history.append(float(relative.max()))
        else:
            relative = on_the_way.begin(start)
        # most often one pass does it; where a method's precision ends, or islands much smaller than the rest lag behind
        # the common norm, the next begins with what is left
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
                f"iterations, {tolerance:.0e} was asked; raise `max_iterations` or `tolerance`, or use a larger beta "
                f"(history: {' '.join(f'{r:.1e}' for r in history[-8:])})",
                tuple(history),
            )
        report(0.0)
        return Solution(on_the_way.finished(), worst, len(history), tuple(history))


class _Solve:
    """One right-hand side on its way: heights without their islands' constants, and what is left of the load.

    A constant has no shape, so the level takes beta * level off the load and nothing else.
    """

    def __init__(self, solver: Solver, load: Float64, held_z: Float64 | None, in_place: bool) -> None:
        self._system, self._method, self._islands = solver.system, solver.method, solver.islands
        held = self._system.held
        for name, given in (("the right-hand side", load), ("the held heights", held_z)):
            if given is not None and given.shape != held.shape:
                raise InputError(f"{name} must be of shape {held.shape}, found {given.shape}")
        self._z = np.zeros(held.shape)
        if held_z is not None:
            np.copyto(self._z, held_z, where=held)
        size = float(np.abs([*extremes(load), *(() if held_z is None else extremes(self._z))]).max())
        if not np.isfinite(size):
            raise InputError("the right-hand side holds NaN or infinite values")
        self._flat = held_z is None or not self._z.any()
        # by a power of two that loses no digit: squares in float32 end at 1e19
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
        """Count residuals against what is left of the load without the level, however large that is."""
        flat = None if self._flat else self._z
        shape = self._islands.residual(self._load, flat, self._room() if left is None else left, self._constants)
        self.scale = np.where(shape > _ROUNDING * self.scale, shape, 0.0)

    def answer(self, method: DirectMethod) -> Float64:
        """Solve in place; the relative residual of each island."""
        self._islands.residual(self._load, None, self._z, self._constants)
        method.answer(self._z)
        self._flat = False
        if not self._islands.floating.any():
            return self._relative(None)
        self._islands.center(self._z)
        return self._relative(self._room())

    def begin(self, start: Float64 | None) -> Float64:
        """Take what was solved before; the relative residual of each island."""
        if start is not None:
            self._put(start)
        elif self._constants.level is None and self._constants.mean is None and self._left is not None:
            return (self.scale > 0).astype(np.float64)  # the scale is the norm of the same residual
        return self._relative(self._room())

    def improve(
        self, relative: Float64, lagging: Mask, tolerance: float, max_iterations: int, report: _Report
    ) -> tuple[Float64, list[float]]:
        """One pass for the islands that lag: the relative residual of each island, and the history of the pass."""
        share = float(relative.max())
        if self._left is None:  # only its norms were wanted before
            self._relative(self._room())
        left = self._room()
        self._islands.keep(lagging, left)
        seen = self._method.improve(self._z, left, tolerance / share, max_iterations, report.times(share))
        self._islands.center(self._z)
        self._flat = False
        now = self._relative(left)
        return now, [*(each * share for each in seen[:-1]), float(now.max())]

    def finished(self) -> Float64:
        """The heights with their constants."""
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
        """(count+1,) residual relative to the load; 0 on islands whose load is 0."""
        norms = self._islands.residual(self._load, None if self._flat else self._z, left, self._constants)
        return np.divide(norms, self.scale, out=np.zeros_like(norms), where=self.scale > 0)

    def _put(self, start: Float64) -> None:
        """Start heights at the unknown vertices, less their level; 0 on islands without a load."""
        z, system, islands = self._z, self._system, self._islands
        if start.shape != z.shape or not np.isfinite(extremes(start)).all():
            raise InputError(f"heights to start from must be finite and of shape {z.shape}, found {start.shape}")
        np.divide(start, self._unit, out=z, where=system.unknown)
        if self._constants.level is not None:  # 0 on islands that are held: those heights stay
            islands.add(z, -self._constants.level)
        silent = self.scale == 0
        silent[0] &= islands.count > 1  # one island's norm counts what belongs to none, too
        if silent.any():
            z[system.unknown & silent[islands.labels]] = 0
        islands.center(z)
        self._flat = False


class _Report:
    """Progress from residuals; it only moves forward."""

    def __init__(self, progress: Progress | None, tolerance: float) -> None:
        self._progress = progress
        self._asked = math.log(tolerance)
        self._shown = 0.0

    def __call__(self, relative: float) -> None:
        """Tell the share that a residual stands for."""
        if self._progress is not None:
            share = math.log(min(max(relative, 1e-300), 1.0)) / self._asked
            self._shown = min(max(share, self._shown), 1.0)
            self._progress("solving", self._shown)

    def times(self, share: float) -> Report | None:
        """The same for residuals relative to one that is ``share`` of the load."""
        return None if self._progress is None else lambda relative: self(relative * share)

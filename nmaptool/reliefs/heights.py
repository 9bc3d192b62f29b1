"""Heights of one system at any delta: z = base + h0 + delta h1, each part solved once."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import ConvergenceError
from nmaptool.core.parallel import for_each_band
from nmaptool.core.progress import Progress
from nmaptool.solver import DirectMethod, Solver

# parts are solved to a tolerance smaller by _CLOSER, so that their sum is in tolerance at every delta except where the
# two loads nearly cancel; rounding allows no tolerance below _CLOSEST
_CLOSER = 8.0
_CLOSEST = 1e-13
# a load this small compared to its two terms is inaccurate
_CANCELLED = 1e-10
_VERTICES_AT_ONCE = 1 << 16


@dataclass(frozen=True, eq=False)
class SolveSettings:
    """Tolerance, iteration limit and progress callback of a solve."""

    tolerance: float
    max_iterations: int
    progress: Progress | None


@dataclass(frozen=True, eq=False)
class SolveStatistics:
    """The solver's iterations for one result, and the residual of that result."""

    residual: float
    iterations: int = 0
    history: tuple[float, ...] = ()

    def after(self, *others: SolveStatistics) -> SolveStatistics:
        """Return these statistics with the iterations of earlier solves added."""
        everything = (*others, self)
        return SolveStatistics(
            self.residual, sum(a.iterations for a in everything), sum((a.history for a in everything), start=())
        )


@dataclass(frozen=True, eq=False)
class _Solved:
    """Heights in px above the background, solved to a residual."""

    above: Float64
    residual: float
    delta: float = 0.0


class SystemHeights:
    """A prepared system, its two loads and the heights solved so far.

    Parameters
    ----------
    solver : Solver
    base_px : (H+1, W+1) float64 or None
        Height of the background; None is 0.
    load : (H+1, W+1) float64
        Load for delta = 0.
    pull : (H+1, W+1) float32
        Load that delta = 1 adds.
    kept : bool
        Whether heights are requested more than once; if not, the load is released when it is used.
    """

    def __init__(self, solver: Solver, base_px: Float64 | None, load: Float64, pull: Float32, kept: bool) -> None:
        self.solver = solver
        self._base = base_px
        self._load: Float64 | None = load
        self._pull = pull
        self._kept = kept
        self._whole: _Solved | None = None
        self._parts: tuple[_Solved, _Solved] | None = None
        self._squares: tuple[Float64, Float64, Float64] | None = None
        self._out_of_reach = 0.0

    def at(
        self, delta: float, settings: SolveSettings, warm_start: SystemHeights | None = None
    ) -> tuple[Float64, SolveStatistics]:
        """Return heights in px above the background, as a new array.

        The first delta is solved directly. The second one splits the heights into their two parts; from then on, the
        heights at every delta are their sum.

        Parameters
        ----------
        delta : float
            Delta in px.
        settings : SolveSettings
        warm_start : SystemHeights, optional
            A system with similar weights; the solver starts from its heights.

        Raises
        ------
        ConvergenceError
            If the solver does not reach its tolerance.
        """
        whole = self._whole
        spent: tuple[SolveStatistics, ...] = ()
        if whole is not None and whole.delta == delta and whole.residual <= settings.tolerance:
            return whole.above.copy(), SolveStatistics(whole.residual)
        if self._kept and (self._parts is not None or (whole is not None and whole.delta != delta)):
            spent = self._split_closer(settings, warm_start)
            residual = self._residual_at(delta)
            if residual <= settings.tolerance:
                return self._sum(delta), SolveStatistics(residual).after(*spent)
        solved, statistics = self._solve_whole(delta, settings, warm_start)
        if not self._kept:
            self._release()
            return solved.above, statistics
        self._whole = solved
        return solved.above.copy(), statistics.after(*spent)

    def parts(
        self, settings: SolveSettings, warm_start: SystemHeights | None = None
    ) -> tuple[Float64, Float64, SolveStatistics]:
        """Return (h0, h1): heights above the background for delta = 0, and what delta = 1 adds. Do not write to them.

        Raises
        ------
        ConvergenceError
            If the solver does not reach its tolerance.
        """
        spent = self._split(settings, warm_start)
        assert self._parts is not None
        first, second = self._parts
        if not self._kept:
            self._release()
        residual = max(first.residual, second.residual)
        return first.above, second.above, SolveStatistics(residual).after(*spent)

    def _release(self) -> None:
        """Release the solver and the loads: no more heights will be requested."""
        del self.solver, self._load, self._pull

    def guess(self, delta: float) -> Float64 | None:
        """Return the best estimate of the heights at a delta that needs no solve; None if there is none."""
        if self._parts is not None:
            return self._sum(delta)
        return None if self._whole is None else self._whole.above

    def _sum(self, delta: float) -> Float64:
        assert self._parts is not None
        out = delta * self._parts[1].above
        out += self._parts[0].above
        return out

    def _solve_whole(
        self, delta: float, settings: SolveSettings, warm_start: SystemHeights | None
    ) -> tuple[_Solved, SolveStatistics]:
        assert self._load is not None
        load = self._load
        if self._kept:
            load = load.copy()
        else:
            self._load = None
        pull = self._pull

        def add(band: slice) -> None:
            load[band] += np.multiply(pull[band], delta, dtype=np.float64)

        for_each_band(len(load), max(1, _VERTICES_AT_ONCE // load.shape[1]), add)
        start = self.guess(delta)
        if start is None and warm_start is not None:
            start = warm_start.guess(delta)
        return self._solve(load, self._base, settings, start, delta)

    def _split_closer(self, settings: SolveSettings, warm_start: SystemHeights | None) -> tuple[SolveStatistics, ...]:
        """Solve the parts accurately enough for their sums to be in tolerance."""
        closer = min(settings.tolerance, max(settings.tolerance / _CLOSER, _CLOSEST))
        if closer <= self._out_of_reach:
            return ()
        try:
            spent = self._split(replace(settings, tolerance=closer), warm_start)
        except ConvergenceError as error:  # the whole may converge even if its parts do not
            self._out_of_reach = closer
            return (SolveStatistics(math.inf, len(error.history), error.history),)
        self._whole = None
        return spent

    def _split(self, settings: SolveSettings, warm_start: SystemHeights | None) -> tuple[SolveStatistics, ...]:
        """Solve the parts that are missing or not in tolerance."""
        first, second = self._parts or (None, None)
        spent = []
        if second is None or second.residual > settings.tolerance:
            start = second.above if second is not None else None
            if start is None and warm_start is not None and warm_start._parts is not None:
                start = warm_start._parts[1].above
            second, statistics = self._solve(self._pull.astype(np.float64), None, settings, start)
            spent.append(statistics)
        if first is None or first.residual > settings.tolerance:
            assert self._load is not None
            if first is not None:
                start = first.above
            elif self._whole is not None:
                start = self._whole.above - self._whole.delta * second.above
            else:
                start = None if warm_start is None else warm_start.guess(0.0)
            first, statistics = self._solve(self._load, self._base, settings, start)
            spent.insert(0, statistics)
        if not self._kept:
            self._load = None
        self._parts = first, second
        return tuple(spent)

    def _solve(
        self, load: Float64, held_z: Float64 | None, settings: SolveSettings, start: Float64 | None, delta: float = 0.0
    ) -> tuple[_Solved, SolveStatistics]:
        if isinstance(self.solver.method, DirectMethod):
            start = None  # a direct method needs no start
        elif start is not None and held_z is not None:
            start = start + held_z
        solution = self.solver.solve(
            load,
            held_z,
            start=start,
            tolerance=settings.tolerance,
            max_iterations=settings.max_iterations,
            progress=settings.progress,
        )
        above = solution.z
        if held_z is not None:
            above -= held_z
        statistics = SolveStatistics(solution.residual, solution.iterations, solution.history)
        return _Solved(above, solution.residual, delta), statistics

    def _residual_at(self, delta: float) -> float:
        """Return an upper bound of the relative residual of the parts' sum, the largest over the islands."""
        if self._parts is None:
            return math.inf
        if self._squares is None:
            self._squares = self._load_squares()
        first, second = self._parts
        square0, product, square1 = self._squares
        terms = square0 + delta * delta * square1
        square = terms + 2 * delta * product
        if (square < _CANCELLED * terms).any():
            return math.inf
        off = first.residual * np.sqrt(square0) + second.residual * abs(delta) * np.sqrt(square1)
        return float(np.max(np.divide(off, np.sqrt(square), out=np.zeros_like(off), where=square > 0)))

    def _load_squares(self) -> tuple[Float64, Float64, Float64]:
        """Return (count+1,) sums per island of the squared first load, the product, and the squared second load."""
        system, islands, cut = self.solver.system, self.solver.islands, self.solver.window.cut
        assert self._load is not None
        first = cut(self._load)
        if self._base is not None:
            first = first - system.apply(np.where(system.held, cut(self._base), 0.0))
        first = np.where(system.unknown, first, 0.0)
        second = np.where(system.unknown, cut(self._pull), 0.0)

        def sums(values: Float64) -> Float64:
            if islands.count == 1:
                return np.array([0.0, values.sum()])
            return np.asarray(np.bincount(islands.labels.ravel(), values.ravel(), islands.count + 1), np.float64)

        return sums(first * first), sums(first * second), sums(second * second)

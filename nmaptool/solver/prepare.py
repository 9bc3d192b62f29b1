"""Choose a solver, prepare it once, and check every answer against the operator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nmaptool.arrays import Float64
from nmaptool.errors import ConvergenceError, InputError, UsageError
from nmaptool.progress import Progress
from nmaptool.solver.islands import Islands
from nmaptool.solver.system import QuadSystem


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
        Relative residual after each iteration, as the solver saw it.
    """

    z: Float64
    residual: float
    iterations: int
    history: tuple[float, ...]


class Method(Protocol):
    """What `nmaptool.solver.dct` and `nmaptool.solver.amg` offer."""

    name: str

    def correct(
        self, residual: Float64, tolerance: float, max_iterations: int, progress: Progress | None
    ) -> tuple[Float64, tuple[float, ...]]:
        """A correction for ``residual`` (zero where nothing is to be solved) and the relative residuals on the way."""


def choose(system: QuadSystem, wanted: str) -> str:
    """The method to use: "auto" takes the DCT where it is exact and algebraic multigrid elsewhere.

    Raises
    ------
    UsageError
        If the method is unknown, or is "dct" for a system that is not a full rectangle with one weight.
    """
    if wanted == "auto":
        return "dct" if system.is_uniform else "amg"
    if wanted not in ("dct", "amg"):
        raise UsageError(f"--solver {wanted!r}: use one of auto, dct, amg")
    if wanted == "dct" and not system.is_uniform:
        raise UsageError(
            "--solver dct: needs a map without background and one weight everywhere; use --solver amg or auto"
        )
    return wanted


class Solver:
    """A prepared system: one set-up, any number of right-hand sides.

    Parameters
    ----------
    system : QuadSystem
    method : Method
    islands : Islands
    """

    def __init__(self, system: QuadSystem, method: Method, islands: Islands) -> None:
        self.system = system
        self.method = method
        self.islands = islands
        self.unknowns = int(system.unknown.sum())

    def solve(
        self,
        load: Float64,
        held_z: Float64 | None = None,
        *,
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
        tolerance : float
            Relative residual to reach on every island.
        max_iterations : int
        progress : callable, optional
            Called with a word and a share in 0..1.

        Raises
        ------
        InputError
            If the load or a held height is not finite.
        ConvergenceError
            If the tolerance is not reached; the history is in the error.
        """
        system = self.system
        z = np.zeros_like(system.beta) if held_z is None else np.where(system.held, held_z, 0.0)
        if not (np.isfinite(load).all() and np.isfinite(z).all()):
            raise InputError("the right-hand side holds NaN or infinite values")
        # a constant has no shape, so the level takes beta * level off the load and nothing else
        level = self.islands.level(load)
        shape_load = load - system.beta * level

        def rest(of: Float64) -> Float64:
            return np.where(system.unknown, of - system.apply(z), 0.0) if z.any() else of * system.unknown

        scale = self.islands.norms(rest(load))
        residual = self.islands.balance(rest(shape_load))
        history: list[float] = []
        worst = self.islands.worst(residual, scale)
        # one pass does it; islands much smaller than the rest may lag behind the common norm and get their own
        while worst > tolerance and len(history) < max_iterations:
            lagging = self.islands.only_lagging(residual, scale, tolerance)
            step, seen = self.method.correct(lagging, tolerance / 2, max_iterations - len(history), progress)
            z += step
            history += seen
            residual = self.islands.balance(rest(shape_load))
            before, worst = worst, self.islands.worst(residual, scale)
            if not worst < 0.5 * before:
                break
        z = level + self.islands.center(z, shape_load)
        if not worst <= tolerance:
            raise ConvergenceError(
                f"the {self.method.name} solver stopped at a relative residual of {worst:.1e} after {len(history)} "
                f"iterations, {tolerance:.0e} was asked; raise --max-iterations or --tolerance, or use a larger beta "
                f"(history: {' '.join(f'{r:.1e}' for r in history[-8:])})",
                tuple(history),
            )
        return Solution(z, worst, len(history), tuple(history))


def prepare(system: QuadSystem, method: str = "auto") -> Solver:
    """Set up a solver for a system.

    Parameters
    ----------
    system : QuadSystem
    method : {"auto", "dct", "amg"}

    Raises
    ------
    UsageError
        As `choose`.
    """
    chosen = choose(system, method)
    islands = Islands(system)
    if chosen == "dct":
        from nmaptool.solver.dct import DctMethod

        return Solver(system, DctMethod(system), islands)
    from nmaptool.solver.amg import AmgMethod

    return Solver(system, AmgMethod(system, islands.anchors), islands)

"""Choose a method, check that there is memory for it, and prepare it once for any number of right-hand sides."""

from __future__ import annotations

import numpy as np

from nmaptool.core.errors import UsageError
from nmaptool.options import SolverName
from nmaptool.options.fields import choice_of
from nmaptool.solver.islands import Islands
from nmaptool.solver.kept import current_keeper
from nmaptool.solver.memory import kind_of, plan
from nmaptool.solver.method import DirectMethod, Method
from nmaptool.solver.solve import Solution, Solver
from nmaptool.solver.system import QuadSystem
from nmaptool.solver.window import window_of

__all__ = ["DirectMethod", "Method", "Solution", "Solver", "choose", "prepare"]

# the time of multigrid depends on the size of the box around the unknowns, that of amg on their number; if their share
# of the box is below this, amg is faster (bench.crossover)
_SPARSE = 0.01


def choose(system: QuadSystem, wanted: str) -> str:
    """Return the name of the method to use.

    "auto" chooses the DCT where it is exact, amg for a few lines on a large picture, and otherwise multigrid.

    Raises
    ------
    UsageError
        If the method is unknown, or is "dct" for a system that is not a full rectangle with one weight.
    """
    choice_of(SolverName).read("solver", wanted)
    if wanted == "auto":
        if system.is_uniform:
            return "dct"
        return "amg" if np.count_nonzero(system.unknown) < _SPARSE * system.unknown.size else "multigrid"
    if wanted == "dct" and not system.is_uniform:
        raise UsageError(
            "`solver='dct'`: needs a map without background and one weight everywhere; use `solver='auto'`"
        )
    return wanted


def prepare(
    system: QuadSystem, method: str = "auto", memory_limit_bytes: int | None = None, like: Solver | None = None
) -> Solver:
    """Set up a solver for a system.

    Parameters
    ----------
    system : QuadSystem
    method : str
        A `nmaptool.options.SolverName`. Under `nmaptool.solver.kept.keeping`, the last solver is returned again for
        equal weights, held vertices and method.
    memory_limit_bytes : int, optional
        Memory that the solve may use. Default: the free memory of the machine.
    like : Solver, optional
        Solver of a similar system, such as before a slider moved. Its coarse levels are reused if possible.

    Raises
    ------
    UsageError
        As for `choose`.
    LimitError
        If it needs more memory than allowed; only the map of unknowns and the weights of the box around them have been
        allocated by then.
    """
    keeper = current_keeper()
    if keeper is not None and like is None:
        kept = keeper.solver_of(system, method)
        if kept is not None:
            kept.check_memory(memory_limit_bytes)
            return kept
        return keeper.keep(system, method, _prepare(system, method, memory_limit_bytes, None))
    return _prepare(system, method, memory_limit_bytes, like)


def _prepare(system: QuadSystem, method: str, memory_limit_bytes: int | None, like: Solver | None) -> Solver:
    window = window_of(system)
    inside = window.system(system)
    chosen = choose(inside, method)
    kind = kind_of(chosen, inside.has_wide_weights)
    planned = plan(inside.weight.shape, int(np.count_nonzero(inside.unknown)), kind, memory_limit_bytes)
    if chosen == "multigrid":
        # imported when used: each method needs libraries that the others do not
        from nmaptool.solver.multigrid.method import MultigridMethod

        other = like.method if like is not None and isinstance(like.method, MultigridMethod) else None
        multigrid = MultigridMethod(inside, other)
        islands = Islands(inside, like.islands if like is not None and multigrid.borrowed else None)
        return Solver(window, inside, multigrid, islands, planned)
    islands = Islands(inside)
    return Solver(window, inside, _method(chosen, inside, islands), islands, planned)


def _method(name: str, system: QuadSystem, islands: Islands) -> Method:
    if name == "dct":
        from nmaptool.solver.dct import DctMethod

        return DctMethod(system)
    from nmaptool.solver.amg import AmgMethod

    return AmgMethod(system, islands)

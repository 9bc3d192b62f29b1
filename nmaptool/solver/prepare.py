"""Choose a method, prepare it once for any number of right-hand sides."""

from __future__ import annotations

from nmaptool.errors import UsageError
from nmaptool.solver.islands import Islands
from nmaptool.solver.method import DirectMethod, Method
from nmaptool.solver.solve import Solution, Solver
from nmaptool.solver.system import QuadSystem

__all__ = ["DirectMethod", "Method", "Solution", "Solver", "choose", "prepare"]


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

    return Solver(system, AmgMethod(system, islands), islands)

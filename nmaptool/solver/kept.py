"""Keep the last prepared solver for systems that are equal to its own, as those of a set of maps with one mask are."""

from __future__ import annotations

import contextlib
import contextvars
from collections.abc import Iterator

import numpy as np

from nmaptool.solver.solve import Solver
from nmaptool.solver.system import QuadSystem


class SolverKeeper:
    """The last prepared solver and the system that it was prepared for.

    The heights are the same bit for bit as with a new solver: a solver does not depend on what it has solved.

    Attributes
    ----------
    prepared, reused : int
        How many solvers were prepared, and how often the kept one was returned instead.
    """

    def __init__(self) -> None:
        self.prepared = 0
        self.reused = 0
        self._kept: tuple[QuadSystem, str, Solver] | None = None

    def solver_of(self, system: QuadSystem, method: str) -> Solver | None:
        """Return the kept solver if it is for an equal system; otherwise None, and forget it to free its memory.

        Parameters
        ----------
        system : QuadSystem
        method : str
            The method that was asked for, such as "auto".
        """
        if self._kept is not None:
            known, asked, solver = self._kept
            if asked == method and _are_equal(known, system):
                self.reused += 1
                return solver
        self._kept = None
        return None

    def keep(self, system: QuadSystem, method: str, solver: Solver) -> Solver:
        """Keep a solver that was prepared for a system, and return it."""
        self.prepared += 1
        self._kept = system, method, solver
        return solver


def _are_equal(one: QuadSystem, other: QuadSystem) -> bool:
    pairs = ((one.weight, other.weight), (one.beta, other.beta), (one.held, other.held))
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


_current: contextvars.ContextVar[SolverKeeper | None] = contextvars.ContextVar("solver keeper", default=None)


def current_keeper() -> SolverKeeper | None:
    """Return the keeper of this context; None outside `keeping`, where every system gets its own solver."""
    return _current.get()


@contextlib.contextmanager
def keeping(keeper: SolverKeeper) -> Iterator[None]:
    """Within the block, let `nmaptool.solver.prepare` keep its last solver in ``keeper`` and reuse it."""
    token = _current.set(keeper)
    try:
        yield
    finally:
        _current.reset(token)

"""Skips slow measurements, based on earlier ones."""

from __future__ import annotations

from bench.runs import Outcome
from bench.systems import Case


class Patience:
    """Skips runs that would exceed the time limit, based on earlier measurements."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._rates: dict[str, float] = {}
        self._alike: dict[tuple[object, ...], float] = {}

    def lacks(self, case: Case, solver: str) -> bool:
        """Whether a run would take too long, at the rate on the same mask or else the best rate so far."""
        rate = self._alike.get(self._kind(case, solver), self._rates.get(solver, 0.0))
        return rate * case.pixels > self._limit

    def learn(self, case: Case, solver: str, outcome: Outcome) -> None:
        """Store the seconds per pixel."""
        took = self._limit * 1.01 if outcome.failure.startswith("over") else outcome.seconds
        if took and (outcome.answers or outcome.failure.startswith("over")):
            rate = took / case.pixels
            self._alike[self._kind(case, solver)] = rate
            self._rates[solver] = min(rate, self._rates.get(solver, rate))

    @staticmethod
    def _kind(case: Case, solver: str) -> tuple[object, ...]:
        return case.family, case.background, case.beta, case.weights, solver

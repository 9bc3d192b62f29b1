"""Conjugate gradients in float32, preconditioned by a V-cycle; the heights themselves are float64."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from nmaptool.arrays import Float32, Float64
from nmaptool.solver.multigrid.hierarchy import Hierarchy
from nmaptool.solver.multigrid.level import new_field
from nmaptool.solver.system import QuadSystem

if TYPE_CHECKING:
    from nmaptool.solver.islands import Islands

# float32 keeps the residual in step with the heights down to about here; then a new one is due
_REDUCTION = 4e-7
_PATIENCE = 3


def _stalls(history: list[float]) -> bool:
    """Whether three iterations brought less than a half: what is left is rounding."""
    return len(history) > _PATIENCE and min(history[-_PATIENCE:]) > 0.5 * min(history[:-_PATIENCE])


class MultigridMethod:
    """One hierarchy, any number of right-hand sides; see `nmaptool.solver.prepare.Method`.

    Parameters
    ----------
    system : QuadSystem
    islands : Islands
    """

    name = "multigrid"
    precision: type[np.floating] = np.float32

    def __init__(self, system: QuadSystem, islands: Islands | None = None) -> None:
        self._hierarchy = Hierarchy(system)
        self._lock = threading.Lock()

    def improve(
        self,
        z: Float64,
        residual: Float32,
        reduction: float,
        max_iterations: int,
        report: Callable[[float], None] | None,
    ) -> tuple[float, ...]:
        """Add a correction for the residual to z; the levels' work space serves one caller at a time."""
        with self._lock:
            return self._improve(z.reshape(-1), residual.reshape(-1), reduction, max_iterations, report)

    def _improve(
        self,
        z: Float64,
        residual: Float32,
        reduction: float,
        max_iterations: int,
        report: Callable[[float], None] | None,
    ) -> tuple[float, ...]:
        finest = self._hierarchy.finest
        edge = finest.edge
        scale = float(max(residual.max(), -residual.min()))
        if scale == 0:
            return (0.0,)
        residual *= np.float32(1 / scale)
        start = math.sqrt(finest.dot(residual, residual))
        work, direction = new_field(finest.shape), new_field(finest.shape)
        inside = direction[edge : edge + finest.size]
        other = np.empty(finest.size, np.float32)  # what the cycle gives, then A times the direction
        history: list[float] = []
        before = math.inf
        while len(history) < max_iterations:
            self._hierarchy.cycle(residual, work, other)
            product = finest.dot(residual, other)
            turn = np.float32(product / before)

            def steer(first: int, last: int, turn: np.float32 = turn) -> None:
                inside[first:last] *= turn
                inside[first:last] += other[first:last]

            finest.in_bands(steer)
            before = product
            curvature = finest.times(direction, other)
            if not (product > 0 and curvature > 0):
                break  # nothing left that float32 can tell
            length = product / curvature

            def move(first: int, last: int, length: float = length) -> float:
                step = np.multiply(inside[first:last], length * scale, dtype=np.float64)
                z[first:last] += step
                part = residual[first:last]
                np.multiply(other[first:last], np.float32(length), out=other[first:last])
                part -= other[first:last]
                return float(np.dot(part, part))

            history.append(math.sqrt(finest.sum_over_bands(move)) / start)
            if report is not None:
                report(history[-1])
            if not history[-1] > max(reduction, _REDUCTION) or _stalls(history):
                break
        return tuple(history)

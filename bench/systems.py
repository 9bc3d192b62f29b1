"""The linear systems for the solver benchmarks, built as in `nmaptool.relief`, and the check of an answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.maps import surface
from bench.masks import FAMILIES, WEIGHTS, statue
from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import corner_sum, touching_vertices
from nmaptool.solver import QuadSystem, slope_load

_ROWS_AT_ONCE = 256
_SLOPE_CAP = 3.0
_DELTA = 30.0
_PRECISION = np.float32  # of the weights


@dataclass(frozen=True)
class Case:
    """One system, by name.

    Parameters
    ----------
    rows, cols : int
    family : str
        One of `bench.masks.FAMILIES`; all but "full" and "statue" are square.
    background : {"plane", "free", "cut"}
        Background of the motif, as for `nmap relief --background`.
    beta : float
        Value at 1000 px on the longer side.
    weights : str
        One of `bench.masks.WEIGHTS`.
    """

    rows: int
    cols: int
    family: str = "statue"
    background: str = "cut"
    beta: float = 0.001
    weights: str = "one"

    @property
    def pixels(self) -> int:
        """Faces of the whole rectangle."""
        return self.rows * self.cols

    def __str__(self) -> str:
        size = f"{self.cols}x{self.rows}" if self.rows != self.cols else f"{self.rows} px"
        shape = self.family if self.family == "full" else f"{self.family} {self.background}"
        return f"{size} {shape}, beta {self.beta:g}" + (f", {self.weights}" if self.weights != "one" else "")


@dataclass(frozen=True, eq=False)
class Problem:
    """A system and one right-hand side for it."""

    system: QuadSystem
    load: Float64


def state(case: Case) -> Problem:
    """The problem of this name."""
    mask = _mask(case)
    weight = WEIGHTS[case.weights]((case.rows, case.cols))
    if case.background != "free":
        weight *= mask
    longer = max(case.rows, case.cols) / 1000
    beta = corner_sum(mask)
    beta *= case.beta / longer**2 / 4
    held = touching_vertices(mask == 0) if case.background == "plane" else np.zeros(beta.shape, bool)
    del mask
    load = slope_load(*_aimed(weight))
    load += beta * (_DELTA * longer)
    return Problem(QuadSystem(weight.astype(_PRECISION), beta.astype(_PRECISION), held), load)


def _mask(case: Case) -> Float32:
    if case.family == "statue":
        return statue(case.rows, case.cols)
    if case.family == "full":
        return np.ones((case.rows, case.cols), np.float32)
    return FAMILIES[case.family](case.rows)[:, : case.cols]


def _aimed(weight: Float32) -> tuple[Float32, Float32]:
    """Capped slopes of the statue of `bench.maps`, multiplied by the weight of each face."""
    p, q = np.empty_like(weight), np.empty_like(weight)
    for first in range(0, weight.shape[0], _ROWS_AT_ONCE):
        band = slice(first, first + _ROWS_AT_ONCE)
        across, up, _ = surface(*weight.shape, band=band)
        gain = weight[band] / np.maximum(np.hypot(across, up) / _SLOPE_CAP, 1)
        p[band], q[band] = across * gain, up * gain
    return p, q


def unknowns(system: QuadSystem) -> Mask:
    """(H+1, W+1) bool: unknown vertices, determined without filling the system's caches."""
    return ~system.held & (touching_vertices(system.weight > 0) | (system.beta > 0))


def relative_residual(problem: Problem, z: Float64) -> float:
    """|load - A z| / |load| over all unknowns, in float64 and directly from Eq. 6, independent of the solver."""
    system, load = problem.system, problem.load
    rows = system.beta.shape[0]
    left = right = 0.0
    for first in range(0, rows, _ROWS_AT_ONCE):
        last = min(first + _ROWS_AT_ONCE, rows)
        faces = slice(max(first - 1, 0), min(last, rows - 1))
        weight = system.weight[faces].astype(np.float64)
        upper, lower = z[faces], z[faces.start + 1 : faces.stop + 1]
        mean = (upper[:, :-1] + upper[:, 1:] + lower[:, :-1] + lower[:, 1:]) / 4
        own = slice(first - faces.start, last - faces.start)
        pull = corner_sum(weight)[own] * z[first:last] - corner_sum(weight * mean)[own]
        pull += system.beta[first:last] * z[first:last]
        free = ~system.held[first:last] & ((corner_sum(weight)[own] > 0) | (system.beta[first:last] > 0))
        left += float(((load[first:last] - pull)[free] ** 2).sum())
        right += float((load[first:last][free] ** 2).sum())
    return float(np.sqrt(left / right)) if right else 0.0

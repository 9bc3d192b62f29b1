"""The solvers side by side on the same maps: ``python -m bench.solver [--sizes 256 512 1024 2048] [--repeat 3]``."""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyamg  # noqa: F401 - loaded here so that no measured set-up pays for it
from scipy.sparse.linalg import splu

from bench.maps import Scene, scene
from bench.table import Surroundings, table, write_section
from nmaptool import ConvergenceError, ReliefOptions
from nmaptool.arrays import Float64
from nmaptool.formulation.domain import lay_out
from nmaptool.formulation.targets import Weights, aim, to_pixels
from nmaptool.solver import QuadSystem, Solver, prepare, slope_load
from nmaptool.solver.amg import assemble
from nmaptool.solver.islands import Islands
from nmaptool.solver.method import Report

MOST_ITERATIONS = 12
_DEFAULTS = ReliefOptions()


@dataclass(frozen=True)
class Case:
    """One kind of system; ``background`` None is the full rectangle, where all backgrounds come to the same."""

    background: str | None
    beta: float

    def __str__(self) -> str:
        return f"{'full' if self.background is None else f'motif {self.background}'}, beta {self.beta:g}"


CASES = (
    *(Case(None, beta) for beta in (0.001, 1, 0)),
    *(Case(background, 0.001) for background in ("plane", "free", "cut")),
    *(Case("cut", beta) for beta in (1, 0)),
)


@dataclass(frozen=True, eq=False)
class Problem:
    """A system and two right-hand sides for it."""

    system: QuadSystem
    loads: tuple[Float64, Float64]


@dataclass(frozen=True)
class Timing:
    """What one solver took for one problem: seconds, and the worse of the two residuals."""

    setup: float
    solve: float
    second: float
    iterations: tuple[int, int]
    residual: float


Samples = dict[tuple[Case, str], list[Timing | ConvergenceError]]


class SuperLuMethod:
    """SciPy's sparse LU in the place of the library's solvers, as `nmaptool.solver.method.Method` asks."""

    name = "superlu"
    precision = np.float64

    def __init__(self, system: QuadSystem, islands: Islands) -> None:
        self._unknown = system.unknown & ~islands.anchors
        # symmetric mode takes the diagonal as pivots: half the time of splu's default here, and the matrix allows it
        self._factors = splu(
            assemble(system, self._unknown).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def improve(
        self, z: Float64, residual: Float64, reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """One direct solve."""
        z[self._unknown] += self._factors.solve(residual[self._unknown])
        return (0.0,)


def _with_superlu(system: QuadSystem) -> Solver:
    islands = Islands(system)
    return Solver(system, SuperLuMethod(system, islands), islands)


SOLVERS: dict[str, Callable[[QuadSystem], Solver]] = {
    "amg": lambda system: prepare(system, "amg"),
    "dct": lambda system: prepare(system, "dct"),
    "superlu": _with_superlu,
}


def state(case: Case, first: Scene, second: Scene) -> Problem:
    """The problem as `nmaptool.relief` states it, with its defaults; the second load comes from other normals."""
    show = Scene.all_surface if case.background is None else Scene.over_ground
    maps = show(first), show(second)
    domain = lay_out(case.background or "plane", maps[0].foreground, maps[0].coverage >= 0.5)
    weights = Weights(0.0, *to_pixels(case.beta, _DEFAULTS.delta, maps[0].frame.longer_side, per_pixel=False))
    targets = [aim(each, None, domain, weights, _DEFAULTS.slope_cap, _DEFAULTS.energy) for each in maps]
    one, two = (slope_load(t.p, t.q) + weights.delta * t.pull for t in targets)
    return Problem(QuadSystem(targets[0].weight, targets[0].beta, domain.held), (one, two))


def relative_residual(system: QuadSystem, load: Float64, z: Float64) -> float:
    """|load - A z| / |load| over all unknowns, from the matrix-free operator."""
    left = np.where(system.unknown, load - system.apply(z), 0.0)
    return float(np.linalg.norm(left) / np.linalg.norm(np.where(system.unknown, load, 0.0)))


def measure(make: Callable[[QuadSystem], Solver], problem: Problem) -> Timing | ConvergenceError:
    """One set-up and two solves."""
    system = dataclasses.replace(problem.system)  # a new one keeps nothing that an earlier solver left in its caches
    moments = [time.perf_counter()]
    solver = make(system)
    moments.append(time.perf_counter())
    solutions = []
    for load in problem.loads:
        try:
            solutions.append(solver.solve(load, tolerance=_DEFAULTS.tolerance))
        except ConvergenceError as error:
            return error
        moments.append(time.perf_counter())
    left = [relative_residual(problem.system, b, s.z) for b, s in zip(problem.loads, solutions, strict=True)]
    setup, solve, second = np.diff(moments).tolist()
    return Timing(setup, solve, second, (solutions[0].iterations, solutions[1].iterations), max(left))


def sample(size: int, repeat: int, direct_limit: int) -> tuple[Samples, dict[Case, int]]:
    """Measure every case at a size ``repeat`` times; also the unknowns of each. A solver left out has no samples."""
    first, second = scene(size, size), scene(size, size, ripple_turn=1.0)
    samples: Samples = {}
    unknowns: dict[Case, int] = {}
    for _ in range(repeat):  # outermost: a burst of other work then spoils one sample of a row, not all of them
        for case in CASES:
            problem = state(case, first, second)
            unknowns[case] = int(problem.system.unknown.sum())
            for name, make in SOLVERS.items():
                if name == "dct" and not problem.system.is_uniform:
                    continue
                taken = samples.setdefault((case, name), [])
                if name != "superlu" or unknowns[case] <= direct_limit:
                    taken.append(measure(make, problem))
    return samples, unknowns


def best(taken: list[Timing | ConvergenceError]) -> Timing | None:
    """The least time of each part; None if there is no sample or one did not converge."""
    timings = [each for each in taken if isinstance(each, Timing)]
    if not timings or len(timings) < len(taken):
        return None
    setup, solve, second = (min(getattr(t, part) for t in timings) for part in ("setup", "solve", "second"))
    return dataclasses.replace(timings[0], setup=setup, solve=solve, second=second)


def cells_of(taken: list[Timing | ConvergenceError], amg: Timing | None) -> list[str]:
    """The measured part of a table row."""
    took = best(taken)
    if took is None:
        return ["no convergence" if taken else "left out", *[""] * 5]
    iterations = "{} / {}".format(*took.iterations)
    ratio = f"{(took.setup + took.solve) / (amg.setup + amg.solve):.2f}" if amg else ""
    return [f"{took.setup:.3f}", f"{took.solve:.3f}", iterations, f"{took.residual:.1e}", f"{took.second:.3f}", ratio]


_HEADER = ("case", "solver", "unknowns", "setup s", "solve s", "iterations", "residual", "2nd solve s", "x amg")


def _preface(options: argparse.Namespace) -> str:
    side = max(options.sizes)
    share = scene(side, side).motif.mean()
    return (
        f"Square pictures; the motif covers {share:.0%} of one; `full` is all surface. beta is meant at 1000 px on the "
        f"longer side.\nSetup is everything before a right-hand side: islands, assembly, hierarchy or factors. Times "
        f"are the best of {options.repeat}.\nIterations and residual (by the matrix-free operator, the worse) are of "
        f"two right-hand sides on one setup, each solved from zero to {_DEFAULTS.tolerance:g}.\n`x amg` is setup + "
        f"solve over that of amg. superlu is left out above {options.direct_limit:,} unknowns."
    )


def _check(counts: dict[Case, list[int | None]], sizes: list[int]) -> str:
    found = [count for row in counts.values() for count in row]
    span = f"from {min(sizes)} to {max(sizes)} px"
    known = [count for count in found if count is not None]
    if len(known) < len(found):
        return f"check: amg did not converge in {len(found) - len(known)} of {len(found)} cases {span}: FAILED"
    verdict = "ok" if max(known) <= MOST_ITERATIONS else "FAILED"
    return f"check: amg takes {min(known)} to {max(known)} iterations {span}, {MOST_ITERATIONS} allowed: {verdict}"


def main() -> None:
    """Measure, print and, with --write, keep."""
    parser = argparse.ArgumentParser(prog="python -m bench.solver", description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024, 2048], help="pixels on a side")
    parser.add_argument("--repeat", type=int, default=3, help="times are the best of this many (default 3)")
    parser.add_argument("--direct-limit", type=int, default=610_000, help="most unknowns for superlu")
    parser.add_argument("--write", action="store_true", help="keep the results in results.md")
    options = parser.parse_args()
    surroundings = Surroundings("bench.solver")
    counts: dict[Case, list[int | None]] = {case: [] for case in CASES}
    body: list[str] = []

    def say(text: str) -> None:
        print(text, end="\n\n", flush=True)
        body.append(text)

    say(_preface(options))
    for size in options.sizes:
        samples, unknowns = sample(size, options.repeat, options.direct_limit)
        amg = {case: best(samples[case, "amg"]) for case in CASES}
        rows = [
            [str(case), name, f"{unknowns[case]:,}", *cells_of(taken, amg[case])]
            for (case, name), taken in samples.items()
        ]
        for case, took in amg.items():
            counts[case].append(None if took is None else max(took.iterations))
        say(f"### {size} px\n\n{table(_HEADER, rows)}")
    sides = [f"{size} px" for size in options.sizes]
    shown = [[str(case), *("none" if n is None else str(n) for n in row)] for case, row in counts.items()]
    say(f"### Iterations of amg, the more of the two\n\n{table(['case', *sides], shown)}")
    say(_check(counts, options.sizes))
    say(surroundings.describe())
    if options.write:
        write_section("solver", "\n\n".join([body[-1], *body[:-1]]))


if __name__ == "__main__":
    main()

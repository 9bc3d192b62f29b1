"""All solvers on the same systems: ``python -m bench.solver [--sizes 512 1024 2048 4096]``."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from bench.bandwidth import Bandwidth, bandwidth
from bench.patience import Patience
from bench.public_solver import compare
from bench.reach import checks
from bench.report import Report
from bench.rivals import SOLVERS
from bench.runs import Answer, Job, Outcome, measure
from bench.systems import Case
from bench.table import table
from bench.tasks import transforms

TOLERANCES = (1e-6, 1e-10)
Results = dict[tuple[Case, str], Outcome]


def groups_of(sizes: list[int], side: int) -> dict[str, list[Case]]:
    """The measured cases, by title; thin masks and weights at one size."""

    def square(family: str = "statue", weights: str = "one", beta: float = 0.001) -> Case:
        return Case(side, side, family, beta=beta, weights=weights)

    motif = [Case(900, 1000, background=background) for background in ("cut", "plane", "free")]
    thin = [square(family) for family in ("tree", "lines 20%", "maze", "noise", "hair")]
    weights = [square(weights=name) for name in ("mu map", "span 1e4", "span 1e4, 16 px", "span 1e12")]
    full = [Case(900, 1000, "full"), square("full", "mu map"), *(Case(n, n, "full") for n in sizes[-2:])]
    return {
        "A motif at 1000x900 px": [*motif, Case(900, 1000, beta=0.0)],
        "The motif by size": [Case(n, n) for n in sizes],
        "Thin and ragged masks": [*thin, square("tree", beta=1e-5)],
        "Weights per pixel": weights,
        "Full rectangles": full,
    }


def reference(results: Mapping[tuple[Case, str], Outcome], case: Case) -> Outcome | None:
    """The user's result: the cosine transform if it applies, else multigrid, else amg."""
    for name in ("dct", "multigrid", "amg"):
        outcome = results.get((case, name))
        if outcome is not None and any(outcome.answers):
            return outcome
    return None


def row_of(case: Case, solver: str, outcome: Outcome, best: Outcome | None, memory: Bandwidth) -> list[str]:
    """One row of the table."""
    named = [str(case), solver]
    if outcome.failure:
        return [*named, outcome.failure, *[""] * 11]
    cells = [f"{outcome.setup:.3f}"]
    for which, answer in enumerate(outcome.answers):
        if answer is None:
            cells += ["no convergence", "", "", ""]
            continue
        total, least = outcome.setup + answer.solve, None if best is None else best.total(which)
        ratio = "" if least is None else f"{total / least:.2f}"
        cells += [f"{answer.solve:.3f}", str(answer.iterations), f"{answer.residual:.0e}", ratio]
    first = outcome.answers[0]
    once = "" if first is None else f"{(outcome.setup + first.solve) / memory.once(case.pixels):.0f}"
    return [*named, *cells, once, *_memory_cells(outcome.answers, case)]


def _memory_cells(answers: tuple[Answer | None, ...], case: Case) -> list[str]:
    peaks = [answer.peak for answer in answers if answer is not None]
    return [f"{max(peaks) / 1e6:.0f}", f"{max(peaks) / case.pixels:.0f}"] if peaks else ["", ""]


_HEADER = (
    *("case", "solver", "setup s", "to 1e-6 s", "it.", "residual", "x ours"),
    *("to 1e-10 s", "it.", "residual", "x ours", "x once", "peak MB", "B/px"),
)


def _preface(options: argparse.Namespace, memory: Bandwidth) -> str:
    return (
        "Setup is all work before a right-hand side: islands, assembly, hierarchy or factors. Both solves start from "
        f"zero.\nTimes are the best of up to 12 within {options.spend:g} s. Each solver runs in its own process, "
        "with modules loaded; the peak\nexcludes the inputs. Residuals are those of the whole system, computed in "
        "float64 from the energy, not by the solver.\n`x ours` is the ratio of setup + solve to that of the first of "
        f"dct, multigrid, amg that solves the case. Left out: runs of more than {options.limit:.0f} s.\n\n{memory}"
    )


def sample(cases: list[Case], chosen: list[str], patience: Patience, options: argparse.Namespace) -> Results:
    """Measure every solver on each case, one after the other."""
    results: Results = {}
    for case in cases:
        for solver in chosen:
            if patience.lacks(case, solver):
                outcome = Outcome(failure="left out")
            else:
                (outcome,) = measure([Job(case, solver, TOLERANCES)], options.limit + 60, options.spend)
                patience.learn(case, solver, outcome)
            results[case, solver] = outcome
    return results


def _shown(results: Results) -> list[tuple[Case, str]]:
    """Leave out the cosine transform where it does not apply, and solvers that are not installed."""
    hidden = ("cannot", "not there", "not installed")
    return [key for key, outcome in results.items() if outcome.failure not in hidden]


def _missing(results: Results) -> str:
    names = {name: outcome.failure for (_, name), outcome in results.items() if outcome.failure.startswith("not ")}
    return "\n".join(f"{name} is {why}." for name, why in names.items())


def _report() -> Report:
    report = Report("solver", __doc__)
    report.argument("--sizes", type=int, nargs="+", default=[512, 1024, 2048, 4096], help="sides in pixels")
    report.argument("--side", type=int, default=1024, help="side of thin masks and of weights (default 1024)")
    report.argument("--solvers", nargs="+", choices=[*SOLVERS, "auto"], default=list(SOLVERS))
    report.argument("--limit", type=float, default=200, help="time limit for one solver on one case, seconds")
    report.argument("--spend", type=float, default=2, help="seconds to spend on repeats of each job (default 2)")
    return report


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = _report()
    options = report.begin()
    memory = bandwidth()
    body: list[str] = []

    def say(text: str) -> None:
        print(text, end="\n\n", flush=True)
        body.append(text)

    say(_preface(options, memory))
    results: Results = {}
    patience = Patience(options.limit)
    for title, cases in groups_of(sorted(options.sizes), options.side).items():
        found = sample(cases, options.solvers, patience, options)
        results |= found
        rows = [row_of(*key, found[key], reference(found, key[0]), memory) for key in _shown(found)]
        say(f"### {title}\n\n{table(_HEADER, rows) if rows else 'nothing measured'}")
    say("\n\n".join(part for part in (_missing(results), compare(options.limit, options.spend)) if part))
    say("\n".join(checks(results, transforms(4096, 4096, 3))))
    say(report.surroundings())
    report.write("\n\n".join([body[-1], *body[:-1]]))


if __name__ == "__main__":
    main()

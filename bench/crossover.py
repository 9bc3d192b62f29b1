"""Where one of our methods overtakes another: ``python -m bench.crossover [--sizes 64 128 256 512 1024 2048 4096]``.

The rules of ``--solver auto`` are based on these tables.
"""

from __future__ import annotations

import argparse

from bench.masks import FAMILIES, WEIGHTS
from bench.patience import Patience
from bench.report import Report
from bench.runs import Job, Outcome, measure
from bench.systems import Case
from bench.table import line, table
from nmaptool import ReliefOptions

METHODS = ("multigrid", "dct", "amg", "dct + CG")
MOST_ITERATIONS = 15
_TOLERANCE = ReliefOptions().tolerance
Results = dict[tuple[Case, str], Outcome]


def kinds(side: int) -> list[Case]:
    """Every mask; also the motif, a thin mask and the full rectangle with other weights and betas."""
    masks = [Case(side, side, family) for family in FAMILIES]
    betas = [Case(side, side, f, beta=b) for f in ("statue", "tree", "lines 20%") for b in (1.0, 1e-5, 0.0)]
    backgrounds = [Case(side, side, background=background) for background in ("plane", "free")]
    weights = [Case(side, side, weights=name) for name in WEIGHTS if name != "one"]
    mapped = [Case(side, side, "full", weights=name) for name in ("mu map", "span 1e4, 16 px")]
    return [*masks, *backgrounds, *betas, *weights, *mapped]


def sample(case: Case, patience: Patience, options: argparse.Namespace) -> Results:
    """Every method, and the library's choice, on one case in one process."""
    jobs = [Job(case, name, (_TOLERANCE,)) for name in (*METHODS, "auto") if not patience.lacks(case, name)]
    found = measure(jobs, options.limit * len(jobs) + 60, options.spend)
    results: Results = {(case, name): Outcome(failure="left out") for name in (*METHODS, "auto")}
    for job, outcome in zip(jobs, found, strict=True):
        patience.learn(case, job.solver, outcome)
        results[case, job.solver] = outcome
    return results


def _cell(outcome: Outcome) -> str:
    total = outcome.total(0)
    if total is None:
        return {"cannot": "", "not there": "", "left out": "..."}.get(outcome.failure, outcome.failure or "none")
    answer = outcome.answers[0]
    return f"{total * 1e3:.0f} ({answer.iterations if answer else ''})"


def fastest(results: Results, case: Case) -> tuple[str, float] | None:
    """The fastest method and its seconds."""
    totals = [(results[case, name].total(0), name) for name in METHODS]
    known = [(total, name) for total, name in totals if total is not None]
    return (min(known)[1], min(known)[0]) if known else None


def _regret(results: Results, case: Case) -> float | None:
    best, chosen = fastest(results, case), results[case, "auto"].total(0)
    return None if best is None or chosen is None else chosen / best[1]


def rows_of(results: Results, cases: list[Case]) -> list[list[str]]:
    """One row for each case of a size."""
    rows = []
    for case in cases:
        best, regret = fastest(results, case), _regret(results, case)
        cells = [_cell(results[case, name]) for name in METHODS]
        chosen = "" if regret is None else f"{regret:.2f}"
        rows.append([str(case), *cells, best[0] if best else "none", chosen])
    return rows


def _named(case: Case) -> str:
    return str(case).partition(" px ")[2]


def by_size(results: Results, sizes: list[int]) -> str:
    """The fastest method of each kind at each size."""
    rows = []
    for each in zip(*(kinds(side) for side in sizes), strict=True):
        best = [fastest(results, case) for case in each]
        rows.append([_named(each[0]), *(b[0] if b else "none" for b in best)])
    return table(["fastest", *(f"{side} px" for side in sizes)], rows)


def iterations(results: Results, sizes: list[int]) -> str:
    """Iterations of multigrid by kind and size, and whether they stay within the limit."""
    counts: list[int] = []
    missed = 0
    rows = []
    for each in zip(*(kinds(side) for side in sizes), strict=True):
        cells = []
        for case in each:
            outcome = results[case, "multigrid"]
            answer = outcome.answers[0] if outcome.answers else None
            cells.append(str(answer.iterations) if answer else outcome.failure or "none")
            counts += [answer.iterations] if answer else []
            missed += answer is None and outcome.failure not in ("not there", "left out")
        rows.append([_named(each[0]), *cells])
    shown = table(["iterations of multigrid", *(f"{side} px" for side in sizes)], rows)
    what = f"iterations of multigrid to {_TOLERANCE:g}"
    lines = [line(f"most {what}", max(counts, default=None), MOST_ITERATIONS, "")]
    if counts:
        lines.append(line("cases that multigrid does not solve", missed, 0, ""))
    return "\n\n".join([shown, "\n".join(lines)])


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("crossover", __doc__)
    sizes = [64, 128, 256, 512, 1024, 2048, 4096]
    report.argument("--sizes", type=int, nargs="+", default=sizes, help="pixels on a side")
    report.argument("--limit", type=float, default=30, help="time limit per method and case, seconds (default 30)")
    report.argument("--spend", type=float, default=0.3, help="seconds to spend on repeats of each job (default 0.3)")
    options = report.begin()
    options.sizes.sort()
    patience = Patience(options.limit)
    results: Results = {}
    preface = (
        f"Milliseconds of setup and one solve to {_TOLERANCE:g}, iterations in brackets; `...` would take more than "
        f"{options.limit:.0f} s. `dct + CG`\nis not a method of the library. `auto` is the time of `--solver auto` "
        "divided by that of the fastest. The methods of a row share a process."
    )
    print(preface)
    body = [preface]
    for side in options.sizes:
        for case in kinds(side):
            results |= sample(case, patience, options)
        header = ("case", *METHODS, "fastest", "auto")
        body.append(f"### {side} px\n\n{table(header, rows_of(results, kinds(side)))}")
        print(f"\n{body[-1]}", flush=True)
    regrets = [each for case, name in results if name == "auto" and (each := _regret(results, case)) is not None]
    worst = f"`auto` takes at most {max(regrets):.2f} times as long as the fastest." if regrets else "auto: no times"
    body += [by_size(results, options.sizes), iterations(results, options.sizes), worst, report.surroundings()]
    print("", *body[-4:], sep="\n\n")
    report.write("\n\n".join([body[-1], *body[:-1]]))


if __name__ == "__main__":
    main()

"""Goals of the solvers on two cores, in CPU seconds, and whether they meet them."""

from __future__ import annotations

from collections.abc import Mapping

from bench.runs import Outcome
from bench.systems import Case
from bench.table import line

_MOTIFS = [Case(900, 1000, background=background) for background in ("cut", "plane", "free")]
_THIN = [Case(1024, 1024, family) for family in ("tree", "lines 20%", "maze", "noise", "hair")]
Results = Mapping[tuple[Case, str], Outcome]


def checks(results: Results, transforms: float | None = None) -> list[str]:
    """One line per goal; ``transforms`` are the seconds of SciPy's transforms at 4096 px, there and back."""
    large, small = Case(4096, 4096), Case(1024, 1024)
    full = results.get((Case(4096, 4096, "full"), "dct"))
    cosine = None if full is None else full.total(0)
    return [
        line(
            "a motif at 1000x900 px, setup and solve to 1e-6, CPU",
            _worst(results, _MOTIFS, 0),
            0.12,
            "s",
            rival=_rival(results, 0),
        ),
        line("the same as a share of the time of amg with assembly", _share(results), 1 / 15, "of it"),
        line(
            "a motif at 1000x900 px, setup and solve to 1e-10, CPU",
            _worst(results, _MOTIFS, 1),
            0.25,
            "s",
            rival=_rival(results, 1),
        ),
        *_thin(results),
        line("the motif at 4096 px, setup and solve to 1e-6, CPU", _total(results, large, "multigrid", 0), 2.5, "s"),
        line("its memory beyond the input", _bytes_per_pixel(results, large), 60, "bytes per pixel"),
        line("time per pixel at 8192 px over that at 1024 px", _growth(results, small, Case(8192, 8192)), 1.3, "times"),
        line("dct at 4096 px to 1e-6", cosine, _twice(transforms), "s", rival=("SciPy's transforms", transforms)),
    ]


def _thin(results: Results) -> list[str]:
    """Thin and ragged masks, with the goal of the motif per pixel."""
    goal = round(0.12 * _THIN[0].pixels / 9e5, 3)
    return [
        line(
            f"{case.family} at 1024 px, setup and solve to 1e-6, CPU",
            _total(results, case, "multigrid", 0),
            goal,
            "s",
            rival=("pyamg", _total(results, case, "aggregation", 0)),
        )
        for case in _THIN
    ]


def _total(results: Results, case: Case, solver: str, which: int) -> float | None:
    """CPU seconds."""
    outcome = results.get((case, solver))
    return None if outcome is None else outcome.cpu(which)


def _twice(seconds: float | None) -> float | None:
    return None if seconds is None else round(2 * seconds, 3)


def _rival(results: Results, which: int) -> tuple[str, float | None]:
    """The faster of PARDISO and pyamg's aggregation, by the motif on which each is slowest."""
    found = {"PARDISO": "pardiso", "pyamg": "aggregation"}
    times = {name: _worst(results, _MOTIFS, which, solver) for name, solver in found.items()}
    known = {name: seconds for name, seconds in times.items() if seconds is not None}
    return min(known.items(), key=lambda item: item[1], default=("pyamg", None))


def _worst(results: Results, cases: list[Case], which: int, solver: str = "multigrid") -> float | None:
    totals = [_total(results, case, solver, which) for case in cases]
    known = [total for total in totals if total is not None]
    return max(known) if len(known) == len(totals) else None


def _share(results: Results) -> float | None:
    pairs = [(_total(results, case, "multigrid", 0), _total(results, case, "amg", 0)) for case in _MOTIFS]
    shares = [mine / its for mine, its in pairs if mine is not None and its is not None]
    return max(shares) if len(shares) == len(pairs) else None


def _bytes_per_pixel(results: Results, case: Case) -> float | None:
    outcome = results.get((case, "multigrid"))
    first = outcome.answers[0] if outcome is not None and outcome.answers else None
    return None if first is None else first.peak / case.pixels


def _growth(results: Results, small: Case, large: Case) -> float | None:
    totals = [_total(results, case, "multigrid", 0) for case in (small, large)]
    if totals[0] is None or totals[1] is None:
        return None
    return totals[1] / large.pixels / (totals[0] / small.pixels)

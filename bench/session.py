"""A live preview: repeated reliefs of one map while a slider moves: ``python -m bench.session [--sides 512 1000]``."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from statistics import median

import numpy as np

import nmaptool as nm
from bench.maps import Scene, scene
from bench.masks import FAMILIES
from bench.report import Report
from bench.table import line, table

_STEPS = 12
_SLIDERS = ("mu", "beta", "slope_cap", "delta", "height", "width")
_PREVIEW = 2e-5
MOST_ERROR = 1e-4  # of the range of the heights
# at most, by the side of the picture
_MOST_SECONDS = {512: 0.040, 1000: 0.100}
_MOST_WITHOUT_A_SOLVE = 0.001
MASKS = ("statue", "full", "tree", "lines 20%", "noise")


def moved(slider: str, start: nm.ReliefOptions) -> Iterator[nm.ReliefOptions]:
    """Options for a series of small moves of one slider."""
    for step in range(1, _STEPS + 1):
        value = {
            "mu": 0.1 * 1.05**step,
            "beta": 0.001 * 1.05**step,
            "slope_cap": 3 * 0.98**step,
            "delta": 30 + step,
            "height": nm.length(f"{3 + step / 10:g}mm"),
            "width": nm.length(f"{100 + step:g}mm"),
        }[slider]
        yield dataclasses.replace(start, **{slider: value})


@dataclasses.dataclass
class Measured:
    """Seconds of the first relief and of each step of each slider, and the largest error of previews."""

    seconds: dict[str, list[float]]
    error: float


def measure(maps: tuple[nm.NormalMap, nm.NormalMap], start: nm.ReliefOptions) -> Measured:
    """Move each slider, and compare the last preview of each with a fresh relief."""
    session = nm.ReliefSession(*maps)

    def timed(options: nm.ReliefOptions) -> tuple[float, nm.Relief]:
        begun = time.perf_counter()
        relief = session.solve(options, preview_tolerance=_PREVIEW)
        return time.perf_counter() - begun, relief

    measured = Measured({"first": [timed(start)[0]]}, 0.0)
    for slider in _SLIDERS:
        timed(start)
        steps = [timed(options) for options in moved(slider, start)]
        # skip the first move: it solves for both parts of the heights, linear in delta
        measured.seconds[slider] = [seconds for seconds, _ in steps][1:]
        exact = nm.relief(*maps, options=list(moved(slider, start))[-1]).z_mm
        off = np.abs(steps[-1][1].z_mm - exact).max() / np.ptp(exact)
        measured.error = max(measured.error, float(off))
    return measured


def maps_of(family: str, side: int) -> tuple[nm.NormalMap, nm.NormalMap]:
    """A map and its detail on a mask."""
    first, second = scene(side, side), scene(side, side, ripple_turn=1.0)
    if family == "full":
        return first.all_surface(), second.all_surface()
    mask = FAMILIES[family](side) > 0
    return Scene(first.normals, mask).cut_out(), Scene(second.normals, mask).cut_out()


def most_seconds(slider: str, side: int) -> float | None:
    """The goal of a step of a slider; None if it has none at this size."""
    if slider in ("delta", "height", "width"):
        return _MOST_WITHOUT_A_SOLVE if side == min(_MOST_SECONDS) else None
    return _MOST_SECONDS.get(side)


def rows_at(side: int) -> tuple[list[list[str]], list[str]]:
    """The rows of the table for one size, and its checks."""
    rows, worst, error = [], dict.fromkeys(_SLIDERS, 0.0), 0.0
    for family in MASKS:
        maps = maps_of(family, side)
        for background in ("cut",) if family == "full" else ("cut", "plane"):
            named = [f"{side} px", f"{family} {background}"]
            try:
                measured = measure(maps, nm.ReliefOptions(background=background))
            except nm.NmaptoolError as failure:
                rows.append([*named, str(failure)[:40], *[""] * (len(_SLIDERS) + 1)])
                continue
            middle = {slider: median(times) for slider, times in measured.seconds.items()}
            worst = {slider: max(worst[slider], middle[slider]) for slider in _SLIDERS}
            error = max(error, measured.error)
            cells = [f"{middle[s] * 1e3:.1f} ({min(measured.seconds[s]) * 1e3:.1f})" for s in _SLIDERS]
            rows.append([*named, f"{middle['first'] * 1e3:.0f}", *cells, f"{measured.error:.0e}"])
    checks = [line(f"error of previews at {side} px, of the range", error, MOST_ERROR, "")]
    for slider in _SLIDERS:
        most = most_seconds(slider, side)
        if most is not None:
            checks.append(line(f"new {slider} at {side} px, any mask", worst[slider], most, "s"))
    return rows, checks


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("session", __doc__)
    report.argument("--sides", type=int, nargs="+", default=list(_MOST_SECONDS), help="sides in pixels (512 1000)")
    options = report.begin()
    measure(maps_of("statue", 64), nm.ReliefOptions(background="cut"))  # loads modules before timing
    found = [rows_at(side) for side in options.sides]
    preface = (
        f"`nm.ReliefSession` with two maps and a preview tolerance of {_PREVIEW:g}: milliseconds of the first relief,\n"
        f"then of a relief after a small slider move: the median of {_STEPS - 1} and, in brackets, the minimum. The\n"
        f"error is the largest difference from a relief solved to {nm.ReliefOptions().tolerance:g}, relative to its "
        "range."
    )
    header = ("size", "mask", "first", *(f"new {slider}" for slider in _SLIDERS), "error")
    report.end(
        preface,
        table(header, [row for rows, _ in found for row in rows]),
        "\n".join(check for _, checks in found for check in checks),
    )


if __name__ == "__main__":
    main()

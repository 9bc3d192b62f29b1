"""A live preview: repeated reliefs of one map while a slider moves: ``python -m bench.session [--side 512]``."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from statistics import median

import nmaptool as nm
from bench.maps import Scene, scene
from bench.masks import FAMILIES
from bench.reach import line
from bench.report import Report
from bench.table import table

_STEPS = 12
_SLIDERS = ("mu", "beta", "delta", "height")
_MOST_SECONDS = {"mu": 0.040, "beta": 0.040, "delta": 0.005, "height": 0.005}
MASKS = ("statue", "full", "tree", "lines 20%", "noise")


def moved(slider: str, start: nm.ReliefOptions) -> Iterator[nm.ReliefOptions]:
    """Options for a series of small moves of one slider."""
    for step in range(1, _STEPS + 1):
        value = {
            "mu": 0.1 * 1.05**step,
            "beta": 0.001 * 1.05**step,
            "delta": 30 + step,
            "height": nm.length(f"{3 + step / 10:g}mm"),
        }[slider]
        yield dataclasses.replace(start, **{slider: value})


def measure(maps: tuple[nm.NormalMap, nm.NormalMap], start: nm.ReliefOptions) -> dict[str, list[float]]:
    """Seconds of the first relief and of each step of each slider."""
    session = nm.ReliefSession(*maps)

    def seconds(options: nm.ReliefOptions) -> float:
        begun = time.perf_counter()
        session.solve(options)
        return time.perf_counter() - begun

    taken = {"first": [seconds(start)]}
    for slider in _SLIDERS:
        seconds(start)
        # skip the first move: it solves for both parts of the heights, linear in delta
        taken[slider] = [seconds(options) for options in moved(slider, start)][1:]
    return taken


def maps_of(family: str, side: int) -> tuple[nm.NormalMap, nm.NormalMap]:
    """A map and its detail on a mask."""
    first, second = scene(side, side), scene(side, side, ripple_turn=1.0)
    if family == "full":
        return first.all_surface(), second.all_surface()
    mask = FAMILIES[family](side) > 0
    return Scene(first.normals, mask).cut_out(), Scene(second.normals, mask).cut_out()


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("session", __doc__)
    report.argument("--side", type=int, default=512, help="side in pixels (default 512)")
    options = report.begin()
    rows, worst = [], dict.fromkeys(_SLIDERS, 0.0)
    measure(maps_of("statue", 64), nm.ReliefOptions(background="cut"))  # loads modules before timing
    for family in MASKS:
        maps = maps_of(family, options.side)
        for background in ("cut",) if family == "full" else ("cut", "plane"):
            start = nm.ReliefOptions(background=background)
            try:
                taken = measure(maps, start)
            except nm.NmaptoolError as error:
                rows.append([f"{family} {background}", str(error)[:40], *[""] * len(_SLIDERS)])
                continue
            middle = {slider: median(times) for slider, times in taken.items()}
            worst = {slider: max(worst[slider], middle[slider]) for slider in _SLIDERS}
            cells = [f"{middle['first'] * 1e3:.0f}"]
            cells += [f"{middle[s] * 1e3:.1f} ({min(taken[s]) * 1e3:.1f})" for s in _SLIDERS]
            rows.append([f"{family} {background}", *cells])
    preface = (
        f"`nm.ReliefSession` at {options.side} px with two maps and a tolerance of {nm.ReliefOptions().tolerance:g}: "
        f"milliseconds of the first relief,\nthen of a relief after a small slider move: the median of "
        f"{_STEPS - 1} and, in brackets, the minimum."
    )
    report.end(
        preface,
        table(("mask", "first", *(f"new {slider}" for slider in _SLIDERS)), rows),
        "\n".join(line(f"new {s} at {options.side} px, any mask", worst[s], _MOST_SECONDS[s], "s") for s in _SLIDERS),
    )


if __name__ == "__main__":
    main()

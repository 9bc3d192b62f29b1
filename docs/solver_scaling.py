"""Time and memory of the solvers by size: ``python docs/solver_scaling.py [--measure] [--most-megapixels 268]``.

Draws pictures/solver_scaling.png from solver_scaling.json. With --measure it first measures, each point in its
own process, and stores the results in that file, where points of other sizes and methods are kept.
"""

from __future__ import annotations

import argparse
import json
import sys
from datetime import date
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from bench.bandwidth import bandwidth  # noqa: E402
from bench.patience import Patience  # noqa: E402
from bench.runs import Job, Outcome, measure  # noqa: E402
from bench.systems import Case  # noqa: E402
from bench.table import cpu_model  # noqa: E402
from nmaptool.core.memory import available_bytes  # noqa: E402

DATA = Path(__file__).with_name("solver_scaling.json")
PICTURE = ROOT / "docs" / "pictures" / "solver_scaling.png"
TOLERANCE = 1e-8
_MOST_BYTES = 60  # per pixel, drawn as a reference line
SIDES = (512, 1024, 2048, 4096, 8192, 16384)
CURVES = {
    "dct, full rectangle": ("dct", "full", "#4c72b0", "o"),
    "multigrid, solid mask": ("multigrid", "statue", "#c44e52", "o"),
    "multigrid, thin mask": ("multigrid", "lines 20%", "#c44e52", "^"),
    "amg, solid mask": ("amg", "statue", "#777777", "o"),
}
Points = dict[str, dict[str, dict[str, Any]]]  # of a curve and a side


def measured(options: argparse.Namespace) -> Points:
    """All curves, as far as limits and memory allow."""
    patience = Patience(options.limit)
    found: Points = {}
    for name, (method, family, _, _) in CURVES.items():
        if method not in options.methods:
            continue
        room = available_bytes() or float("inf")
        densest = 0.0
        for side in SIDES:
            case = Case(side, side, family)
            inputs = 18 * case.pixels  # weights, height weights, held and load
            if case.pixels > options.most_megapixels * 1.0e6 * 1.01 or patience.lacks(case, method):
                break
            if densest * case.pixels + inputs > 0.95 * room:
                print(f"{name}, {side} px: would not fit in memory", flush=True)
                break
            (outcome,) = measure([Job(case, method, (TOLERANCE,))], options.limit + 120, options.spend)
            patience.learn(case, method, outcome)
            answer = outcome.answers[0] if outcome.answers else None
            print(f"{name}, {side} px: {_said(outcome)}", flush=True)
            if answer is None:
                break
            densest = answer.peak / case.pixels
            found.setdefault(name, {})[str(side)] = {
                "setup_s": round(outcome.setup, 4),
                "solve_s": round(answer.solve, 4),
                "iterations": answer.iterations,
                "residual": float(f"{answer.residual:.1e}"),
                "peak_bytes": answer.peak,
                "unknowns": outcome.unknowns,
            }
    return found


def _said(outcome: Outcome) -> str:
    answer = outcome.answers[0] if outcome.answers else None
    if answer is None:
        return outcome.failure or "no convergence"
    return (
        f"{outcome.setup:.2f} + {answer.solve:.2f} s, {answer.iterations} iterations, residual {answer.residual:.0e}, "
        f"{answer.peak / 1e9:.2f} GB"
    )


def draw(data: dict[str, Any]) -> None:
    """Two panels by number of pixels: seconds and bytes."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    mpl.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    figure, (seconds, memory) = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
    ends = [SIDES[0] ** 2 / 1e6, SIDES[-1] ** 2 / 1e6]
    for name, (_, _, color, marker) in CURVES.items():
        points = sorted((int(side), point) for side, point in data["points"].get(name, {}).items())
        if not points:
            continue
        megapixels = [side**2 / 1e6 for side, _ in points]
        style = {"color": color, "marker": marker, "markersize": 4, "linewidth": 1.3, "label": name}
        style["linestyle"] = "--" if marker == "^" else "-"
        seconds.plot(megapixels, [p["setup_s"] + p["solve_s"] for _, p in points], **style)
        memory.plot(megapixels, [p["peak_bytes"] / 1e9 for _, p in points], **style)
    once = [data["once_s_per_megapixel"] * each for each in ends]
    seconds.plot(ends, once, color="#bbbbbb", linewidth=1, linestyle=":", label="map read, height written once")
    memory.plot(ends, [_MOST_BYTES * end / 1e3 for end in ends], color="#bbbbbb", linewidth=1, linestyle=":")
    memory.annotate(
        f"{_MOST_BYTES} bytes per pixel",
        (ends[1] / 4, _MOST_BYTES * ends[1] / 4e3),
        color="#888888",
        fontsize=8,
        va="top",
        xytext=(6, -4),
        textcoords="offset points",
    )
    for axes, title in (
        (seconds, "setup and one solve to 1e-8, seconds"),
        (memory, "most memory beyond the input, GB"),
    ):
        axes.set(xscale="log", yscale="log", xlabel="megapixels", title=title)
        axes.set_xticks([side**2 / 1e6 for side in SIDES], ["0.26", "1", "4", "17", "67", "268"])
        axes.minorticks_off()
        axes.grid(alpha=0.25, linewidth=0.6)
        axes.yaxis.set_major_formatter(mpl.ticker.FuncFormatter(lambda value, _: f"{value:g}"))
        axes.title.set_fontsize(10)
    figure.legend(*seconds.get_legend_handles_labels(), frameon=False, fontsize=9, loc="outside lower center", ncols=5)
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=110, metadata={"Software": None})


def main() -> None:
    """Measure if requested, and draw."""
    parser = argparse.ArgumentParser(prog="python docs/solver_scaling.py", description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure again instead of drawing the stored results")
    methods = list(dict.fromkeys(method for method, *_ in CURVES.values()))
    parser.add_argument(
        "--methods", nargs="+", choices=methods, default=methods, help="methods to measure (default: all)"
    )
    parser.add_argument("--most-megapixels", type=float, default=269, help="largest size (default 269: all)")
    parser.add_argument("--limit", type=float, default=400, help="time limit for one point, seconds (default 400)")
    parser.add_argument("--spend", type=float, default=2, help="seconds of repeats for one point (default 2)")
    options = parser.parse_args()
    data: dict[str, Any] = json.loads(DATA.read_text()) if DATA.exists() else {"points": {}}
    if options.measure:
        speed = bandwidth()
        data |= {
            "date": date.today().isoformat(),
            "machine": cpu_model(),
            "tolerance": TOLERANCE,
            "once_s_per_megapixel": speed.once(1_000_000),
        }
        for name, points in measured(options).items():
            data["points"].setdefault(name, {}).update(points)
        DATA.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    if "once_s_per_megapixel" not in data:
        parser.error(f"{DATA.name} does not exist yet: create it with --measure")
    draw(data)


if __name__ == "__main__":
    main()

"""Plates with their solids, and pictures of reliefs: ``python -m bench.plates [--runs 5]``."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import nmaptool as nm
from bench.maps import scene
from bench.report import Report
from bench.table import line, table

ROWS, COLS = 900, 1000
_LEGEND = "LIBERTAS ET VERITAS"
# a picture of 1000 x 900 px from above
_MOST_PICTURE = 1.0


def measured(work: Callable[[], Any], runs: int) -> tuple[float, float, Any]:
    """Least wall seconds and least CPU seconds of some runs, and the last result."""
    walls, cpus, found = [], [], None
    for _ in range(runs):
        wall, cpu = time.perf_counter(), time.process_time()
        found = work()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    return min(walls), min(cpus), found


def pictures(relief: nm.Relief, runs: int) -> tuple[list[list[str]], list[str]]:
    """Pictures in every material from above, and one in perspective."""
    rows, checks = [], []
    views = [(material, "top") for material in nm.MATERIALS] + [("bronze", "iso")]
    for material, view in views:
        options = nm.PreviewOptions(material=material, view=view, size=COLS)  # type: ignore[arg-type]
        wall, cpu, picture = measured(lambda options=options: nm.preview(relief, options), runs)
        rows.append(
            [f"picture, {material}, {view}", f"{wall:.2f}", f"{cpu:.2f}", "x".join(map(str, picture.shape[:2]))]
        )
        most = _MOST_PICTURE if view == "top" else None
        checks.append(line(f"picture of {COLS} x {ROWS} px, {material}, {view}", wall, most, "s"))
    return rows, checks


def coins(runs: int) -> list[list[str]]:
    """A coin with a rope and a legend: its heights, and its solid."""
    motif = scene(ROWS, COLS).cut_out()
    text = nm.TextOptions(text=_LEGEND, text_path="arc", text_size=nm.length("2mm"))
    frame = nm.FrameOptions(frame=nm.length("2mm"), frame_profile="rope")
    design = nm.read_design(nm.PlateOptions(shape="round"), frame, [text])
    options = nm.ReliefOptions(width=nm.length("38mm"), height=nm.length("1mm"))
    alone, alone_cpu, _ = measured(lambda: nm.relief(motif, options=options), runs)
    plate, plate_cpu, coin = measured(lambda: nm.plate(motif, options=options, design=design), runs)
    closed = nm.SolidOptions(base=nm.length("2mm"))
    solid, solid_cpu, made = measured(lambda: nm.solid(coin, closed).to_mesh(), runs)
    size = f"{coin.height.frame.rows}x{coin.height.frame.cols}"
    return [
        ["relief alone", f"{alone:.2f}", f"{alone_cpu:.2f}", f"{ROWS}x{COLS}"],
        ["coin: rope and legend", f"{plate:.2f}", f"{plate_cpu:.2f}", size],
        [f"its solid, {len(made.faces)} triangles", f"{solid:.2f}", f"{solid_cpu:.2f}", size],
    ]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("plates", __doc__)
    report.argument("--runs", type=int, default=5, help="runs of each job; the shortest counts (default 5)")
    options = report.begin()
    relief = nm.relief(scene(ROWS, COLS).cut_out(), options=nm.ReliefOptions(height=nm.length("4mm")))
    nm.preview(relief, nm.PreviewOptions(size=64))  # loads modules before timing
    rows, checks = pictures(relief, options.runs)
    report.end(
        "Least wall and CPU seconds of several runs, with everything loaded.",
        table(("job", "wall s", "CPU s", "px"), [*coins(options.runs), *rows]),
        "\n".join(checks),
    )


if __name__ == "__main__":
    main()

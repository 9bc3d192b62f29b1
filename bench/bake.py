"""Time of ``nmap bake`` by stage, as ratios in one run: ``python -m bench.bake [--mesh FILE]``.

Do not import anything heavy here: a child inherits the peak memory that its parent had when it started.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench.relief import Job, run
from bench.report import Report
from bench.table import line, table

SIZES = (20_000, 75_000, 300_000, 1_500_000)
WHOLE = "all layers, ring, supersample 1"
RATIO = "surface / ring, sigma_s 8"
DRAWING = "drawing, supersample 1"
CPU = "filter surface, sigma_s 3, CPU"
PEAK = "peak GB"
SCAN = 5_000_000
_SCAN_SECONDS, _SCAN_GB = 60.0, 4.0


@dataclass(frozen=True)
class Goal:
    """Upper limit of a figure for meshes of about this many faces; None: for all sizes."""

    figure: str
    most: float
    faces: int | None = None


GOALS = (
    Goal(CPU, 2.5, 300_000),
    Goal(CPU, 15.0, 1_500_000),
    Goal(WHOLE, 1.34, 300_000),
    Goal(WHOLE, 6.8, 1_500_000),
    Goal(DRAWING, 0.2, 300_000),
    Goal(RATIO, 10.0),
    Goal(PEAK, 3.0, 1_500_000),
)


@dataclass(frozen=True)
class Measured:
    """One mesh: seconds of each stage and other figures, by name."""

    name: str
    wanted: int
    faces: int
    copy: float
    seconds: dict[str, float]
    figures: dict[str, float]


def _child(*arguments: str) -> tuple[dict[str, object], int]:
    """Output of ``bench.bake_stages``, run in its own process, and its peak resident memory in bytes."""
    command = [sys.executable, "-m", "bench.bake_stages", *arguments]
    with tempfile.TemporaryFile() as stated:
        process = subprocess.Popen(command, cwd=Path(__file__).parents[1], stdout=stated)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: exit code {process.returncode}")
        stated.seek(0)
        return json.load(stated), usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def measure(source: str, wanted: int, repeat: int) -> Measured:
    """Measure the stages in one process and the peak of the whole job in another."""
    stages, _ = _child("stages", source, "--repeat", str(repeat))
    _, peak = _child("peak", source)
    seconds = stages["seconds"]
    assert isinstance(seconds, dict)
    ratio = seconds["filter surface, sigma_s 8"] / seconds["filter ring"]
    figures = {RATIO: ratio, PEAK: peak / 1e9}
    return Measured(str(stages["name"]), wanted, int(str(stages["faces"])), seconds.pop("copy"), seconds, figures)


def rows_of(measured: list[Measured]) -> list[list[str]]:
    """One row per stage: seconds and multiples of a copy of the mesh, for each mesh."""
    timed = [
        [stage, *(c for m in measured for c in (_cells(m.seconds[stage], m.copy) if stage in m.seconds else ("", "")))]
        for stage in max((m.seconds for m in measured), key=len)
    ]
    others = [
        [figure, *(c for m in measured for c in (f"{m.figures[figure]:.2f}", ""))] for figure in measured[0].figures
    ]
    return timed + others


def _cells(seconds: float, copy: float) -> tuple[str, str]:
    return f"{seconds:.3f}", f"{seconds / copy:,.0f}"


def goals_of(measured: list[Measured]) -> list[str]:
    """One line for each goal and each of its meshes."""
    lines = []
    for goal in GOALS:
        for m in measured:
            if goal.faces not in (None, m.wanted):
                continue
            what = f"{goal.figure}, {m.name}"
            if goal.figure in m.seconds:
                lines.append(line(what, m.seconds[goal.figure], goal.most, "s", rival=("a plain copy", m.copy)))
            elif goal.figure in m.figures:
                lines.append(line(what, m.figures[goal.figure], goal.most, ""))
    return lines


def command_row(folder: Path, source: str, times: int) -> list[str]:
    """``nmap bake`` on a PLY file, from start to exit."""
    path = folder / "mesh.ply"
    _child("file", source, "--output", str(path))
    files = ("-o", str(folder / "maps"), "--overwrite", "--quiet")
    runs = run(Job("nmap bake", ("bake", str(path), *files), times))
    span = f"{min(runs.seconds):.2f}-{max(runs.seconds):.2f}"
    return ["nmap bake of 75k faces (PLY), default options", str(times), span, f"{runs.peak / 1e9:.2f}"]


def scan_rows(folder: Path) -> tuple[list[list[str]], list[str]]:
    """``nmap bake`` on an STL file of a large scan, once with each neighbourhood: rows, and a line for each goal."""
    path = folder / "scan.stl"
    _child("file", str(SCAN), "--output", str(path))
    rows, lines = [], []
    for neighborhood in ("surface", "ring"):
        files = ("-o", str(folder / "scan"), "--overwrite", "--quiet", "--neighborhood", neighborhood)
        runs = run(Job("nmap bake", ("bake", str(path), *files), 1))
        name = f"nmap bake of {SCAN / 1e6:g}M faces (STL), {neighborhood}"
        rows.append([name, "1", f"{min(runs.seconds):.2f}", f"{runs.peak / 1e9:.2f}"])
        lines.append(line(name, min(runs.seconds), _SCAN_SECONDS, "s"))
        lines.append(line(f"{name}, peak", runs.peak / 1e9, _SCAN_GB, "GB"))
    return rows, lines


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("bake", __doc__)
    report.argument("--sizes", type=int, nargs="+", default=SIZES, help="approximate faces of the generated meshes")
    report.argument("--mesh", help="also measure this file")
    report.argument("--no-scan", action="store_true", help=f"without the scan of {SCAN / 1e6:g}M faces")
    report.argument("--repeat", type=int, default=3, help="number of runs; the shortest time counts (default 3)")
    options = report.begin()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does
    sources = [(str(size), size) for size in options.sizes] + ([(options.mesh, 0)] if options.mesh else [])
    measured = [measure(source, wanted, options.repeat) for source, wanted in sources]
    with tempfile.TemporaryDirectory() as name:
        commands = [command_row(Path(name), "75000", options.repeat)]
        scans, scan_lines = ([], []) if options.no_scan else scan_rows(Path(name))
    preface = (
        "Knobbly spheres with fine bumps, drawn at 1000x900 px; the filter takes 5 passes. Seconds are the best of "
        f"{options.repeat} after imports;\n`x` is the ratio to a plain copy of the mesh's arrays. All layers: "
        "cleaning, filter, mixture, drawing, maps. The peak is that of a process that\nonly makes the mesh and all "
        "layers with `surface` at sigma_s 3 and supersample 2; 1 GB is 1e9 bytes."
    )
    header = ["stage", *(cell for m in measured for cell in (f"{m.name} s", "x"))]
    whole = table(("from start to exit", "runs", "span s", PEAK), commands + scans)
    verdicts = "\n".join(goals_of(measured) + scan_lines)
    report.end(preface, table(header, rows_of(measured)), whole, verdicts)


if __name__ == "__main__":
    main()

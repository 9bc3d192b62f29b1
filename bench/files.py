"""Time and memory of reading a map and of writing every format: ``python -m bench.files [--side 4096]``.

Each job runs in its own process, several times; the least CPU time counts.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.relief import make_maps
from bench.report import Report
from bench.solids import Job, measure
from bench.table import line, table

_MOST_BYTES = 1e9


@dataclass(frozen=True)
class Row:
    """What is measured: its name, the goal in CPU seconds, and what was found, in seconds and bytes."""

    name: str
    most_cpu: float
    work: float
    check: float | None
    peak: float
    size: float

    @property
    def cpu(self) -> float:
        """CPU seconds of everything."""
        return self.work + (self.check or 0.0)

    def cells(self) -> list[str]:
        """The row of the table."""
        checking = "" if self.check is None else f"{self.check:.2f}"
        sizes = [f"{self.peak / 1e9:.2f}", f"{self.size / 1e6:.1f}"]
        return [self.name, f"{self.work:.2f}", checking, f"{self.cpu:.2f}", f"{self.most_cpu:g}", *sizes]


def mesh_row(kind: str, side: int, ending: str, most_cpu: float, repeats: int) -> Row:
    """A surface or a solid to a mesh file, and the check that reads it back."""
    job = Job(kind, side, side, ending, (("base", "3mm"),) if kind == "solid" else ())
    runs = [measure(job) for _ in range(repeats)]
    write, check = (min(run[name] for run in runs) for name in ("write", "check"))
    write += min(run["plan"] for run in runs)
    return Row(
        f"{kind} {side} x {side} to {ending}", most_cpu, write, check, runs[0]["peak with check"], runs[0]["bytes"]
    )


def picture_row(what: str, side: int, path: Path, most_cpu: float, repeats: int) -> Row:
    """A map read, or heights written, which includes their check."""
    words = json.dumps([what, side, str(path), repeats])
    command = [sys.executable, "-m", "bench.files", "--child", words]
    told = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    name = f"map {side} x {side} read" if what == "map" else f"heights {side} x {side} to {path.suffix}"
    return Row(name, most_cpu, told["cpu"], None, told["peak"], path.stat().st_size)


def child(what: str, side: int, path: Path, repeats: int) -> dict[str, float]:
    """CPU seconds and peak above the inputs of one picture."""
    work = _reading(path) if what == "map" else _writing(side, path)
    return _measured(work, repeats)


def _measured(work: Callable[[], Any], repeats: int) -> dict[str, float]:
    from bench import peak

    least, most = float("inf"), 0
    for _ in range(repeats):
        before, started = peak.begin(), time.process_time()
        work()
        least, most = min(least, time.process_time() - started), max(most, peak.peak() - before)
    return {"cpu": least, "peak": most}


def _reading(path: Path) -> Callable[[], Any]:
    import nmaptool as nm

    return lambda: nm.read_normal_map(path)


def _writing(side: int, path: Path) -> Callable[[], Any]:
    from bench.surfaces import bumps
    from nmaptool.io.pictures.heights import write_height

    height = bumps(side, side)
    return lambda: write_height(height, path, {})


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("files", __doc__)
    report.argument("--side", type=int, default=4096, help="side of the large square in pixels (default 4096)")
    report.argument("--repeat", type=int, default=2, help="number of runs; the shortest time counts (default 2)")
    report.argument("--child", help=argparse.SUPPRESS)
    options = report.begin()
    if options.child:
        what, side, path, repeats = json.loads(options.child)
        sys.stdout.write(json.dumps(child(what, side, Path(path), repeats)))
        return
    side, repeats = options.side, options.repeat
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        maps = [folder / f"{each}.png" for each in ("motif", "thin", "full")]
        make_maps(f"{side}x{side}", *maps)
        rows = [
            picture_row("map", side, maps[0], 2.5, repeats),
            mesh_row("surface", side, ".stl", 5, repeats),
            mesh_row("surface", side, ".ply", 6, repeats),
            mesh_row("surface", side, ".glb", 6, repeats),
            mesh_row("surface", side, ".obj", 12, repeats),
            picture_row("heights", side, folder / "a.exr", 2.5, repeats),
            picture_row("heights", side, folder / "a.png", 2.5, repeats),
            mesh_row("solid", side // 2, ".3mf", 10, repeats),
        ]
    head = ("job", "CPU s", "check s", "in all", "goal", "peak GB above the inputs", "MB")
    checks = [line(f"{row.name}, CPU", row.cpu, row.most_cpu, "s") for row in rows]
    checks += [line(f"{row.name}, peak above the inputs", row.peak / 1e9, _MOST_BYTES / 1e9, "GB") for row in rows]
    report.end(table(head, [row.cells() for row in rows]), "\n".join(checks))


if __name__ == "__main__":
    main()

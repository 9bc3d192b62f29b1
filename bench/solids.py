"""Time and memory of triangles: surfaces, solids and fewer triangles: ``python -m bench.solids [--side 4096]``.

Each job runs in its own process, which reports CPU seconds and the peak of memory above the heights.
"""

from __future__ import annotations

import argparse
import itertools
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from bench.report import Report
from bench.table import line, table


@dataclass(frozen=True)
class Job:
    """Size in pixels, file ending, options of the solid, and goals: CPU seconds and bytes above the heights."""

    name: str
    cols: int
    rows: int
    ending: str
    options: tuple[tuple[str, str], ...] = ()
    most_cpu: float | None = None
    most_bytes: float | None = None


def jobs(side: int) -> tuple[Job, ...]:
    """All jobs: a picture of 1000 x 900 and a square of the given side."""
    base, hollow = (("base", "3mm"),), (("base", "6mm"), ("hollow", "1.2mm"))
    small = (1000, 900)
    return (
        Job("surface", *small, ".stl", (), 0.4),
        Job("solid", *small, ".stl", base, 0.6),
        Job("solid", *small, ".3mf", base),
        Job("hollow solid", *small, ".stl", hollow),
        Job("surface", side, side, ".stl", (), 12.0, 0.3e9),
        Job("solid", side, side, ".stl", base, 18.0, 0.3e9),
        Job("solid, error 1 % of the height", side, side, ".stl", (*base, ("max_error", "0.04mm")), 20.0, 3e9),
        Job("solid, 200k triangles", side, side, ".3mf", (*base, ("triangles", "200k"))),
    )


def child(job: Job) -> dict[str, float]:
    """Make, write and check one solid; CPU seconds of each stage, and the peak above the heights."""
    import dataclasses

    import numpy as np

    import nmaptool as nm
    from bench import peak
    from bench.surfaces import bumps
    from nmaptool.io.solids.check import check_written
    from nmaptool.io.solids.writer import write_solid

    height = bumps(job.rows, job.cols)
    values = {name: text if name == "triangles" else nm.length(text) for name, text in job.options}
    options = dataclasses.replace(nm.SolidOptions(), **values)  # type: ignore[arg-type]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"solid{job.ending}"
        write_solid(nm.solid(nm.Height(np.ones((9, 9)), np.ones((8, 8), bool), nm.Frame(8, 8, 1.0)), options), path)
        before = peak.begin()
        marks = [time.process_time()]
        solid = nm.solid(height, options)
        marks.append(time.process_time())
        write_solid(solid, path, is_checked=False)
        marks.append(time.process_time())
        above = peak.peak() - before
        check_written(solid, path)
        marks.append(time.process_time())
        checking = peak.peak() - before
        size = path.stat().st_size
    stages = [after - start for start, after in itertools.pairwise(marks)]
    return {
        "plan": stages[0],
        "write": stages[1],
        "check": stages[2],
        "peak": above,
        "peak with check": checking,
        "faces": solid.face_count,
        "bytes": size,
        "error": solid.facts.get("max_error_mm", 0.0),
    }


def measure(job: Job) -> dict[str, float]:
    """`child` in its own process.

    Raises
    ------
    RuntimeError
        If it fails.
    """
    words = json.dumps([job.name, job.cols, job.rows, job.ending, job.options])
    command = [sys.executable, "-m", "bench.solids", "--child", words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{job.name}: {done.stderr}")
    told: dict[str, float] = json.loads(done.stdout)
    return told


def checks_of(job: Job, told: dict[str, float]) -> list[str]:
    """One line for each goal of a solid; reading the file back may take as long as making and writing it."""
    name, cpu = _name(job), told["plan"] + told["write"]
    lines = []
    if job.most_cpu is not None:
        lines.append(line(f"{name}, CPU", cpu, job.most_cpu, "s"))
    if job.most_cpu is not None and "max_error" not in dict(job.options):
        lines.append(line(f"{name}, CPU with its check", cpu + told["check"], 2 * job.most_cpu, "s"))
    if job.most_bytes is not None:
        lines.append(line(f"{name}, peak above heights", told["peak"] / 1e6, job.most_bytes / 1e6, "MB"))
    return lines


def _name(job: Job) -> str:
    return f"{job.name}, {job.cols} x {job.rows}, {job.ending}"


def _row(job: Job, told: dict[str, float]) -> list[str]:
    return [
        _name(job),
        f"{told['faces'] / 1e6:.3g} M",
        f"{told['bytes'] / 1e6:.3g} MB",
        f"{told['plan']:.2f} + {told['write']:.2f}" + (f" (goal {job.most_cpu:g})" if job.most_cpu else ""),
        f"{told['check']:.2f}",
        f"{told['peak'] / 1e6:.0f} MB" + (f" (goal {job.most_bytes / 1e6:.0f})" if job.most_bytes else ""),
        f"{told['error']:.3g} mm" if told["error"] else "",
    ]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("solids", __doc__)
    report.argument("--side", type=int, default=4096, help="side of the large square in pixels (default 4096)")
    report.argument("--child", help=argparse.SUPPRESS)
    options = report.begin()
    if options.child:
        name, cols, rows, ending, given = json.loads(options.child)
        print(json.dumps(child(Job(name, cols, rows, ending, tuple(map(tuple, given))))))
        return
    measured = [(job, measure(job)) for job in jobs(options.side)]
    head = ["solid", "triangles", "file", "CPU s: plan + write", "check", "peak above heights", "error"]
    lines = [text for each in measured for text in checks_of(*each)]
    report.end(table(head, [_row(*each) for each in measured]), "\n".join(lines))


if __name__ == "__main__":
    main()

"""Time and memory of the whole command from start to exit: ``python -m bench.relief [--size 1000x900]``.

Do not import anything heavy here: a child inherits the peak memory that its parent had when it started.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from bench.report import Report
from bench.table import line, table

MOST_BYTES = 1.2e9
COMMANDS = ("bake", "compose", "compose blend", "inspect", "relief", "smooth")


@dataclass(frozen=True)
class Job:
    """One command line of ``nmap``, its number of runs and its limits; None: no goal."""

    name: str
    arguments: tuple[str, ...]
    times: int
    most_seconds: float | None = None
    most_bytes: float | None = None
    report: Path | None = None


@dataclass(frozen=True)
class Runs:
    """Wall seconds and CPU seconds of each run, and their largest peak in bytes."""

    seconds: tuple[float, ...]
    cpu_seconds: tuple[float, ...]
    peak: int


def jobs_in(folder: Path, masked: Path, thin: Path, full: Path) -> tuple[Job, ...]:
    """All jobs."""

    def preview_of(map_path: Path) -> tuple[str, str]:
        return "--preview", str(folder / f"{map_path.stem}-view.png")

    def relief(name: str, map_path: Path, most_seconds: float, *more: str, ending: str = "exr") -> Job:
        report = folder / f"{name}.json"
        files = ("-o", str(folder / f"{map_path.stem}.{ending}"), "--report", str(report), "--overwrite", "--quiet")
        return Job(name, ("relief", str(map_path), *files, *more), 3, most_seconds, MOST_BYTES, report)

    return (
        relief("relief of a motif to EXR", masked, 1.0),
        relief("relief of a motif, cut, to EXR", masked, 1.0, "--background", "cut"),
        relief("relief of thin lines, cut, to EXR", thin, 1.0, "--background", "cut"),
        relief("relief of a full frame to EXR", full, 1.0, "--background-color", "none"),
        relief("relief of a motif to STL, with preview", masked, 1.6, *preview_of(masked), ending="stl"),
        relief(
            "relief of a full frame to STL, with preview",
            full,
            1.6,
            "--background-color",
            "none",
            *preview_of(full),
            ending="stl",
        ),
        Job("inspect of a motif", ("inspect", str(masked)), 3),
        Job("--help", ("--help",), 5, 0.25),
        *(Job(f"{words} --help", (*words.split(), "--help"), 5, 0.35) for words in COMMANDS),
    )


def run(job: Job) -> Runs:
    """Run the installed command ``job.times`` times.

    Raises
    ------
    RuntimeError
        If the exit code is not 0; the message includes its stderr.
    """
    # next to this interpreter, because "nmap" on the PATH may be the network scanner
    return run_command([str(Path(sysconfig.get_path("scripts")) / "nmap"), *job.arguments], job.times)


def run_command(command: Sequence[str], times: int) -> Runs:
    """Run a program once without and then ``times`` times with measuring it.

    Raises
    ------
    RuntimeError
        If the exit code is not 0; the message includes its stderr.
    """
    # an installed command has its bytecode, whatever the shell says
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    seconds, cpu_seconds, peaks = [], [], []
    for turn in range(times + 1):
        with tempfile.TemporaryFile() as messages:
            started = time.perf_counter()
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages, env=environment)
            _, status, usage = os.wait4(process.pid, 0)
            if turn:  # the first run may compile
                seconds.append(time.perf_counter() - started)
                cpu_seconds.append(usage.ru_utime + usage.ru_stime)
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode != 0:
                messages.seek(0)
                raise RuntimeError(f"{' '.join(command)}: exit code {process.returncode}: {messages.read().decode()}")
        peaks.append(usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024))
    return Runs(tuple(seconds), tuple(cpu_seconds), max(peaks))


def make_maps(size: str, *paths: Path) -> tuple[float, float]:
    """Write the inputs in a separate process; return the coverage of motif and thin lines."""
    made = subprocess.run(
        [sys.executable, "-m", "bench.map_files", size, *map(str, paths)],
        cwd=Path(__file__).parents[1],
        check=True,
        stdout=subprocess.PIPE,
    )
    motif, thin = map(float, made.stdout.split())
    return motif, thin


def _against(figure: float, goal: float | None) -> list[str]:
    if goal is None:
        return ["", ""]
    return [f"{goal:g}", f"{figure / goal:.0%}{' MISSED' if figure > goal else ''}"]


def row_of(job: Job, runs: Runs) -> list[str]:
    """Wall time and its range, the least CPU time and the peak; the last two with their goals."""
    wall = median(runs.seconds)
    span = f"{min(runs.seconds):.2f}-{max(runs.seconds):.2f}"
    peak_goal = None if job.most_bytes is None else job.most_bytes / 1e9
    cpu = min(runs.cpu_seconds)  # other processes change it little
    time_cells = [str(job.times), f"{wall:.2f}", span, f"{cpu:.2f}", *_against(cpu, job.most_seconds)]
    return [job.name, *time_cells, f"{runs.peak / 1e9:.2f}", *_against(runs.peak / 1e9, peak_goal)]


def account_of(job: Job, report: Path) -> list[str]:
    """Figures from the report of the last run."""
    stated = json.loads(report.read_text(encoding="utf-8"))
    seconds = [f"{stated['seconds'][part]:.2f}" for part in ("reading", "setup", "solve", "writing")]
    return [job.name, stated["solver"], f"{stated['unknowns']:,}", *seconds, str(stated["iterations"])]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("relief", __doc__)
    report.argument("--size", default="1000x900", help="columns x rows in pixels (default 1000x900)")
    options = report.begin()
    rows, layer_reports, checks = [], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = folder / "masked.png", folder / "thin.png", folder / "full.png"
        share, thin_share = make_maps(options.size, *paths)
        for job in jobs_in(folder, *paths):
            runs = run(job)
            rows.append(row_of(job, runs))
            if job.most_seconds is not None:
                checks.append(line(f"{job.name}, CPU", min(runs.cpu_seconds), job.most_seconds, "s", peak=runs.peak))
            if job.most_bytes is not None:
                checks.append(line(f"{job.name}, peak", runs.peak / 1e9, job.most_bytes / 1e9, "GB"))
            if job.report is not None:
                layer_reports.append(account_of(job, job.report))
    preface = (
        f"`nmap` with its defaults on 16-bit PNG of {options.size} px; the motif covers {share:.0%} of it (alpha), "
        f"the thin lines {thin_share:.0%},\nthe full frame has no background. Measured from process start to "
        "exit: median wall time, the least CPU time and the\nlargest peak of resident memory. Goals are upper limits "
        "of the last two for 1000x900 px; 1 GB is 1e9 bytes."
    )
    header = ("job", "runs", "wall s", "span s", "CPU s", "goal s", "of goal", "peak GB", "goal GB", "of goal")
    account_header = (
        "from its own report",
        "solver",
        "unknowns",
        "reading s",
        "setup s",
        "solve s",
        "writing s",
        "iterations",
    )
    report.end(preface, table(header, rows), table(account_header, layer_reports), "\n".join(checks))


if __name__ == "__main__":
    main()

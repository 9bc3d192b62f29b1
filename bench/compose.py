"""Time and memory of map editing, compared with one copy: ``python -m bench.compose [--size 4096]``.

Do not import anything heavy here: a child inherits the peak memory that its parent had when it started.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from bench.report import Report
from bench.table import line, table

SIZE = 4096
MOST_IMAGES = 6.0
_ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Job:
    """One edit, by its name in `bench.compose_jobs`, and its limits; None: no goal.

    ``most_copies`` is in units of one copy of the input maps, measured in the same process.
    """

    name: str
    most_seconds: float | None = None
    most_copies: float | None = None
    most_images: float | None = MOST_IMAGES


JOBS = (
    *(Job(f"blend vectors, {mode}", most_copies=5.0) for mode in ("rnm", "pd", "whiteout", "udn", "linear", "overlay")),
    Job("blend vectors, rnm, soft mask"),
    Job("blend, rnm, with curl before and after"),
    Job("paste, turned by 33 degrees", 2.0),
    Job("paste, turned by 90 degrees", 2.0),
    Job("paste, turned by 33 degrees, feather 24 px, rnm"),
    Job("transform, turned by 30 degrees"),
    Job("transform, turned by 90 degrees"),
    Job("transform, resized to 3/4"),
    Job("transform, stretched to half its height"),
    Job("stack of 5 layers"),
    # its copies are those of the small map; its peak is in images of the whole size
    Job("split, a quarter of the side, sigma_s 8 px"),
    *(Job(f"depth, {kind}", 3.0) for kind in ("8 bit", "16 bit", "float")),
)


def measure(job: Job, size: int, repeat: int) -> dict[str, float]:
    """Output of `bench.compose_jobs` for one job, run in its own process."""
    command = [sys.executable, "-m", "bench.compose_jobs", job.name, str(size), str(repeat)]
    done = subprocess.run(command, cwd=_ROOT, check=True, stdout=subprocess.PIPE)
    stated: dict[str, float] = json.loads(done.stdout)
    return stated


def _against(figure: float, goal: float | None) -> list[str]:
    if goal is None:
        return [f"{figure:.2f}", ""]
    return [f"{figure:.2f}", f"{goal:g}{' MISSED' if figure > goal else ''}"]


def checks_of(job: Job, stated: dict[str, float]) -> list[str]:
    """One line for each goal of a job."""
    seconds, copy, images = (stated[name] for name in ("seconds", "copy", "images"))
    lines = []
    if job.most_seconds is not None:
        lines.append(line(job.name, seconds, job.most_seconds, "s", rival=("a plain copy", copy)))
    if job.most_copies is not None:
        lines.append(line(f"{job.name}, in copies", seconds / copy, job.most_copies, "copies"))
    if job.most_images is not None:
        lines.append(line(f"{job.name}, peak in images", images, job.most_images, "images"))
    return lines


def row_of(job: Job, stated: dict[str, float]) -> list[str]:
    """Time, its ratio to the time of a copy, and peak, each with its goal."""
    cells = [*_against(stated["seconds"], job.most_seconds), f"{stated['slowest']:.2f}"]
    copies = _against(stated["seconds"] / stated["copy"], job.most_copies)
    return [job.name, *cells, *copies, *_against(stated["images"], job.most_images)]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("compose", __doc__)
    report.argument("--size", type=int, default=SIZE, help="side of the background in pixels (default 4096)")
    report.argument("--repeat", type=int, default=5, help="number of runs; the shortest time counts (default 5)")
    report.argument("--only", default="", help="only jobs whose names contain this text")
    options = report.begin()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does
    jobs = [job for job in JOBS if options.only in job.name]
    measured = [(job, measure(job, options.size, options.repeat)) for job in jobs]
    preface = (
        f"Waves and ripples in float32, {options.size} x {options.size} px; the pasted disc and four layers "
        "of the stack have half\nthat size; depth images show 30 overlapping hemispheres. Each job runs in its own "
        f"process. Seconds are the best of {options.repeat} after\nimports and inputs, `slowest` is the longest time, "
        "`copies` the ratio to copying the input maps into new arrays, measured in\nalternation with the job. Results "
        "are freed before the next run, so that both start with the same memory. The peak is the growth\nof the "
        "process's resident memory after imports and inputs, including results, in float images of that size\n"
        "(H x W x 3 float32). Goals are upper limits for 4096 px on 2 cores."
    )
    header = ("job", "s", "goal s", "slowest s", "copies", "goal", "peak images", "goal images")
    rows = [row_of(*each) for each in measured]
    report.end(preface, table(header, rows), "\n".join(text for each in measured for text in checks_of(*each)))


if __name__ == "__main__":
    main()

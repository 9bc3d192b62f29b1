"""A set of maps against the ideal: ``python -m bench.batch [--maps 200] [--size 512]``.

The ideal is the time of reading, solving and writing each map in one warm process and one thread, over the cores.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

import nmaptool as nm
from bench.checks import line
from bench.maps import scene
from bench.report import Report
from bench.table import table
from nmaptool.core.parallel import at_most, cores

_MOST_RATIO = 1.2
_HEIGHT = "4mm"
# maps that are measured alone, before and after the batch
_ALONE = 24


class Seconds(NamedTuple):
    """Wall and CPU seconds."""

    wall: float
    cpu: float


def write_maps(folder: Path, count: int, size: int) -> list[Path]:
    """Maps of one size and mask whose normals lean to different sides."""
    picture = scene(size, size)
    random = np.random.default_rng(5)
    paths = [folder / f"map{number:03}.png" for number in range(count)]
    for path in paths:
        normals = picture.normals + random.normal(0, 0.05, 3).astype(np.float32)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        cover = picture.motif.astype(np.float32)
        nm.write_normal_map(nm.NormalMap(normals, cover, nm.Frame(size, size)), path)
    return paths


def seconds_alone(paths: list[Path], folder: Path) -> list[Seconds]:
    """Time of reading, solving and writing each map in this process and one thread."""
    options = nm.ReliefOptions(height=nm.length(_HEIGHT))
    found = []
    with at_most(1):
        for path in paths:
            wall, cpu = time.perf_counter(), time.process_time()
            relief = nm.relief(nm.read_normal_map(path), options=options)
            nm.write_relief(relief, folder / f"{path.stem}.stl", overwrite=True)
            found.append(Seconds(time.perf_counter() - wall, time.process_time() - cpu))
    return found


def seconds_of_plain(paths: list[Path], folder: Path) -> float:
    """Seconds of as many plain processes as there are cores, from their start to their end; each does its share."""
    count, started = cores(), time.perf_counter()
    with multiprocessing.get_context("spawn").Pool(count) as pool:
        pool.starmap(seconds_alone, [(paths[first::count], folder) for first in range(count)], chunksize=1)
    return time.perf_counter() - started


def seconds_of_batch(folder: Path, out: Path) -> tuple[Seconds, list[float]]:
    """Time of the whole command from start to exit with its processes, and the wall time of each item."""
    words = ["batch", "relief", str(folder / "*.png"), "-o", str(out / "{stem}.stl"), "--height", _HEIGHT, "-q"]
    wall, before = time.perf_counter(), os.times()
    done = subprocess.run(
        [sys.executable, "-c", "from nmaptool_cli.start import run\nrun()", *words], capture_output=True, check=True
    )
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return Seconds(time.perf_counter() - wall, cpu), [json.loads(each)["seconds"] for each in done.stdout.splitlines()]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("batch", __doc__)
    report.argument("--maps", type=int, default=200, help="number of maps (default 200)")
    report.argument("--size", type=int, default=512, help="px along each side (default 512)")
    options = report.begin()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "maps").mkdir()
        (folder / "alone").mkdir()
        paths = write_maps(folder / "maps", options.maps, options.size)
        seconds_alone(paths[:2], folder / "alone")  # loads modules before timing
        alone = seconds_alone(paths[:_ALONE], folder / "alone")
        plain = [seconds_of_plain(paths[: len(paths) // 2], folder / "alone")]
        batch, items = seconds_of_batch(folder / "maps", folder / "out")
        plain += [seconds_of_plain(paths[len(paths) // 2 :], folder / "alone")]
        alone += seconds_alone(paths[-_ALONE:], folder / "alone")
        again, _ = seconds_of_batch(folder / "maps", folder / "out")
    wall, cpu = (float(np.mean(each)) for each in zip(*alone, strict=True))
    share, what = options.maps / cores(), f"a batch of {options.maps} maps of {options.size} px"
    rows = [
        [f"{options.maps} maps of {options.size} px to STL", f"{batch.wall:.1f}", f"{batch.cpu:.1f}"],
        [f"one map alone, mean of {len(alone)}", f"{wall:.3f}", f"{cpu:.3f}"],
        ["one map in the batch, mean", f"{float(np.mean(items)):.3f}", ""],
        [f"{cores()} plain processes, each with its share", f"{sum(plain):.1f}", ""],
        [f"ideal: alone x {options.maps} / {cores()} cores", f"{wall * share:.1f}", f"{cpu * options.maps:.1f}"],
        ["the same batch again: every item skipped", f"{again.wall:.1f}", f"{again.cpu:.1f}"],
    ]
    report.end(
        "The whole command from start to exit, with its worker processes; the ideal was measured before and after it.\n"
        "Where other programs use the cores, wall time is unfair to the batch, which needs all of them.",
        table(("job", "wall s", "CPU s"), rows),
        "\n".join(
            (
                line(f"{what} over the ideal, wall", batch.wall / (wall * share), _MOST_RATIO, "x"),
                line(f"{what} over plain processes, wall", batch.wall / sum(plain), _MOST_RATIO, "x"),
                line(f"{what} over the ideal, CPU", batch.cpu / (cpu * options.maps), _MOST_RATIO, "x"),
            )
        ),
    )


if __name__ == "__main__":
    main()

"""Reliefs of maps larger than memory: ``python -m bench.tiled [--side 16384] [--gigapixel] [--folder /scratch]``."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import nmaptool as nm
from bench.large_maps import write_maps
from bench.report import Report
from bench.table import line, table

_START = [sys.executable, "-c", "from nmaptool_cli.start import run; run()"]
_WIDTH = "1000mm"
# a map that one machine of 24 GB still solves in memory
_WHOLE = 8192


@dataclass(frozen=True)
class Measured:
    """One run of the command.

    Attributes
    ----------
    wall : float
        Seconds.
    peak : int
        Largest sum of the resident memory of all processes, in bytes.
    report : mapping
        The report of the command.
    """

    wall: float
    peak: int
    report: Any


@contextmanager
def _watched(process: int) -> Iterator[list[int]]:
    """Look at the memory of a process and its children ten times a second."""
    import psutil

    seen, stop = [0], threading.Event()

    def look() -> None:
        while not stop.wait(0.1):
            try:
                whole = psutil.Process(process)
                everyone = [whole, *whole.children(recursive=True)]
                seen[0] = max(seen[0], sum(each.memory_full_info().uss for each in everyone))
            except psutil.Error:
                continue

    watcher = threading.Thread(target=look, daemon=True)
    watcher.start()
    try:
        yield seen
    finally:
        stop.set()
        watcher.join()


def by_tiles(normals: str, output: Path, flags: Sequence[str]) -> Measured:
    """Run ``nmap relief`` on a store."""
    command = [*_START, "relief", normals, "-o", str(output), "--width", _WIDTH, "--overwrite", "-q", "--json", *flags]
    started = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run, _watched(run.pid) as seen:
        told, _ = run.communicate()
    if run.returncode:
        sys.exit(f"exit code {run.returncode}")
    return Measured(time.perf_counter() - started, seen[0], json.loads(told))


def in_memory(normals: str, mask: str, output: Path) -> float:
    """Seconds of the same relief in memory, from the same store to the same kind of store."""
    from nmaptool.io.stores.opening import create_picture, open_picture

    started = time.perf_counter()
    stored = open_picture(normals)
    everything = slice(0, stored.rows), slice(0, stored.cols)
    reading = nm.ReadOptions(background_color="none")
    original = nm.decode_normal_map(stored.read(*everything), reading)
    chosen = open_picture(mask).read(*everything).pixels[..., 0].astype(np.float32) / 255
    relief = nm.relief(
        original, mask=chosen, options=nm.ReliefOptions(width=nm.length(_WIDTH), height=nm.length("8mm"))
    )
    made = create_picture(str(output), stored.rows, stored.cols, ("Y",), np.float32, overwrite=True)
    made.write(0, 0, relief.height.at_pixels().astype(np.float32))
    return time.perf_counter() - started


def error_of_terrain(folder: Path, side: int, heights: Any, normals: str) -> tuple[float, float]:
    """Root mean square error of heights from the normals of terrain, and that of the terrain itself, in px."""
    from nmaptool.io.stores.heights import open_heights

    output = folder / "terrain.zarr"
    flags = ["--background", "free", "--beta", "0", "--background-color", "none", "--at", "corners"]
    by_tiles(normals, output, flags)
    source = open_heights(str(output))
    sums = np.zeros(5)
    for row in range(0, side, 2048):
        rows = slice(row, min(row + 2048, side))
        found = np.asarray(source.window(rows, slice(0, side)), np.float64) / source.pitch_mm
        truth = heights[rows, :side].astype(np.float64)
        off = found - truth
        sums += off.sum(), (off * off).sum(), truth.sum(), (truth * truth).sum(), off.size
    off, off2, truth, truth2, count = sums
    shutil.rmtree(output)
    return float(np.sqrt(off2 / count - (off / count) ** 2)), float(np.sqrt(truth2 / count - (truth / count) ** 2))


def _row(name: str, side: int, run: Measured) -> list[str]:
    stages = run.report["relief"]["seconds"]
    history = run.report["relief"]["history"]
    how = f"{run.report['tile']} px, overlap {run.report['overlap']}, coarse {run.report['factor']}"
    seconds = ", ".join(f"{stage} {value:.0f}" for stage, value in stages.items())
    minutes = run.wall / 60 / (side * side / 1e9)
    return [name, how, f"{run.wall:.0f}", f"{minutes:.1f}", f"{run.peak / 1e9:.2f}", f"{len(history)}", seconds]


def measure(folder: Path, options: argparse.Namespace) -> tuple[list[list[str]], list[str]]:
    """All rows and checks."""
    rows, checks = [], []
    small = folder / "small"
    small.mkdir()
    normals, mask, _ = write_maps(small, _WHOLE, _WHOLE)
    flags = ["--mask", mask, "--height", "8mm", "--background-color", "none"]
    whole = min(in_memory(normals, mask, small / "whole.zarr") for _ in range(2))
    one = by_tiles(normals, small / "heights.zarr", [*flags, "--workers", "1"])
    two = by_tiles(normals, small / "heights.zarr", [*flags, "--workers", "2"])
    rows += [_row(f"{_WHOLE} px, one worker", _WHOLE, one), _row(f"{_WHOLE} px, two workers", _WHOLE, two)]
    checks.append(line(f"one worker over two, {_WHOLE} px", one.wall / two.wall, None, "times"))
    checks.append(line(f"tiles over memory, {_WHOLE} px", two.wall / whole, 1.5, "times"))
    shutil.rmtree(small)
    side = options.side
    large = folder / "large"
    large.mkdir()
    normals, mask, heights = write_maps(large, side, min(side, 16384))
    flags = ["--mask", mask, "--height", "8mm", "--background-color", "none"]
    run = by_tiles(normals, large / "heights.zarr", [*flags, "--memory-limit", "4GB"])
    rows.append(_row(f"{side} px, 4 GB", side, run))
    scale = (side / _WHOLE) ** 2
    checks.append(
        line(f"tiles, {side} px, over {scale:.0f} times memory at {_WHOLE} px", run.wall / whole / scale, 1.5, "")
    )
    checks.append(line(f"tiles, {side} px, peak", run.peak / 1e9, 4, "GB"))
    error, size = error_of_terrain(large, side, heights, normals)
    checks.append(line(f"terrain, {side} px: RMS error of heights (terrain {size:.3g} px)", error, None, "px"))
    shutil.rmtree(large)
    if options.gigapixel:
        huge = folder / "huge"
        huge.mkdir()
        normals, mask, _ = write_maps(huge, 32768, 16384)
        flags = ["--mask", mask, "--height", "8mm", "--background-color", "none"]
        run = by_tiles(normals, huge / "heights.zarr", [*flags, "--memory-limit", "8GB"])
        rows.append(_row("32768 px, 8 GB", 32768, run))
        checks.append(line("tiles, 32768 px, minutes", run.wall / 60, 40, "min"))
        checks.append(line("tiles, 32768 px, peak", run.peak / 1e9, 8, "GB"))
        shutil.rmtree(huge)
    return rows, checks


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("tiled", __doc__)
    report.argument("--side", type=int, default=16384, help="side of the large map (default 16384)")
    report.argument("--gigapixel", action="store_true", help="also 32768 px, with 40 GB of disk space")
    report.argument("--folder", type=Path, help="where the maps are written (default: the temporary folder)")
    options = report.begin()
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        rows, checks = measure(Path(folder), options)
    report.end(
        "A disc of fractal terrain from 16-bit normals, tolerance 1e-8, from a Zarr store to a Zarr store. Memory is "
        "the largest sum over all processes. In memory, the same relief is measured at the largest size that fits, and "
        "larger ones are taken to need time in proportion to their pixels.",
        table(("job", "tiles", "wall s", "min/Gpx", "peak GB", "sweeps", "seconds of stages"), rows),
        "\n".join(checks),
    )


if __name__ == "__main__":
    main()

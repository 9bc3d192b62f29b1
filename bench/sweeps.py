"""What a sweep over the tiles of a large map gains, by masks and overlaps: ``python -m bench.sweeps``."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from bench.report import Report
from bench.table import table
from nmaptool.io.stores.opening import create_picture
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import BackgroundMode, ReadOptions, ReliefFiles, ReliefOptions
from nmaptool.reliefs.targets import Weights, to_pixels
from nmaptool.solver.tiling.grid import TileGrid
from nmaptool.tiled.inputs import open_sources
from nmaptool.tiled.job import ReliefJob
from nmaptool.tiled.pools import HerePool
from nmaptool.tiled.solving import assembled, coarse_problem, solve

_SIDE, _TILE, _FACTOR = 2048, 512, 4
_OVERLAPS = (8, 16, 32)


def _holes(x: Any, y: Any) -> Any:
    rng = np.random.default_rng(1)
    mask = np.hypot(x - _SIDE / 2, y - _SIDE / 2) < 0.45 * _SIDE
    for _ in range(200):
        col, row, radius = rng.uniform(0, _SIDE), rng.uniform(0, _SIDE), rng.uniform(5, 60)
        mask &= np.hypot(x - col, y - row) > radius
    return mask


def _spiral(x: Any, y: Any) -> Any:
    turn = np.arctan2(y - _SIDE / 2, x - _SIDE / 2) / (2 * np.pi)
    away = np.hypot(x - _SIDE / 2, y - _SIDE / 2)
    return ((away / 24 + turn) % 1 < 0.3) & (away < 0.48 * _SIDE)


# name, background, mask
_CASES: tuple[tuple[str, BackgroundMode, Callable[[Any, Any], Any]], ...] = (
    ("rectangle, free", "free", lambda x, y: (x + y) >= 0),
    ("disc, plane", "plane", lambda x, y: np.hypot(x - _SIDE / 2, y - _SIDE / 2) < 0.45 * _SIDE),
    ("disc with 200 holes, plane", "plane", _holes),
    ("disc with 200 holes, cut", "cut", _holes),
    ("rings 8 px wide, cut", "cut", lambda x, y: np.hypot(x - _SIDE / 2, y - _SIDE / 2) % 24 < 8),
    ("hatching 6 px wide, cut", "cut", lambda x, y: (x + 1.3 * y) % 30 < 6),
    ("spiral 7 px wide, cut", "cut", _spiral),
)


def history(folder: Path, normals: str, mask: str, background: BackgroundMode, overlap: int) -> tuple[float, ...]:
    """Relative residual after each sweep."""
    options = ReliefOptions(background=background)
    files = ReliefFiles(mask=mask)
    sources = open_sources(normals, files, ReadOptions(background_color="none"))
    grid = TileGrid(_SIDE, _SIDE, _TILE, overlap * _FACTOR, _FACTOR)
    beta, delta = to_pixels(options.beta, options.delta, _SIDE, per_pixel=False)
    weights, read = Weights(0.0, beta, delta), (sources.greys, sources.reading, None)
    job = ReliefJob(WorkFolder(str(folder)), grid, normals, files, *read, options, weights, 0.1, 8)
    pool = HerePool()
    records = assembled(job, pool, None)
    return solve(job, pool, "load", records, coarse_problem(job), None).history


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("sweeps", __doc__)
    report.begin()
    rows = []
    y, x = np.mgrid[0:_SIDE, 0:_SIDE].astype(np.float32)
    noise = np.random.default_rng(0).normal(0, 0.1, x.shape)
    steep = np.dstack([np.sin(x / 37) / 2 + np.cos(y / 91 + x / 400) / 2 + noise, 0.7 * np.cos(x / 53 + y / 77)])
    vectors = np.dstack([steep, np.ones_like(x)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    with tempfile.TemporaryDirectory() as folder:
        normals = f"{folder}/normals.zarr"
        create_picture(normals, _SIDE, _SIDE, ("R", "G", "B"), np.float32).write(0, 0, vectors.astype(np.float32))
        for name, background, shape in _CASES:
            mask = f"{folder}/mask.zarr"
            create_picture(mask, _SIDE, _SIDE, ("Y",), np.uint8, overwrite=True).write(
                0, 0, np.where(shape(x, y), 255, 0).astype(np.uint8)
            )
            cells = [name]
            for overlap in _OVERLAPS:
                work = Path(folder) / f"{len(rows)}_{overlap}"
                found = history(work, normals, mask, background, overlap)
                gain = (found[0] / found[-1]) ** (1 / (len(found) - 1)) if len(found) > 1 else np.inf
                cells += [f"{len(found)}", f"{gain:.2g}"]
            rows.append(cells)
    head = [text for overlap in _OVERLAPS for text in (f"sweeps, {overlap}", "gain")]
    report.end(
        f"{_SIDE} px, tiles of {_TILE} px, coarse faces of {_FACTOR} px; overlaps of 8, 16 and 32 coarse faces. "
        "`sweeps` to a residual of 1e-8 of the load; `gain` is the factor by which each after the first reduces it.",
        table(("mask", *head), rows),
    )


if __name__ == "__main__":
    main()

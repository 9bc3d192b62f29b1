"""The compiled loops, compared with their twins in NumPy, on one thread: ``python -m bench.kernels [--write]``."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from bench.file_loops import file_rows
from bench.report import Report
from bench.table import table
from nmaptool import kernels
from nmaptool.core.errors import UsageError
from nmaptool.kernels import coarsening, grid_twins, pair_twins, pixel_twins, sweep_twins, system_twins, transfer_twins

SIZES = ((900, 1000), (4096, 4096))
# as many vertices as the solver gives a loop at once
_BAND = 3 << 16
# large patches in a row, and nodes in each, as for a mesh of 300,000 faces
_PATCHES, _NODES, _REACH = 400, 24, 4
# pixels at once, and cells around each, as in `compose split`
_PIXELS, _CELLS = 65536, 100


def best(work: Callable[[], object], repeats: int) -> float:
    """Shortest CPU time in milliseconds."""
    least = np.inf
    for _ in range(repeats):
        started = time.process_time()
        work()
        least = min(least, time.process_time() - started)
    return least * 1e3


def grid_loops(rows: int, cols: int) -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """The loops over a grid: their twins, and their arguments without the range."""
    random, size, edge = np.random.default_rng(0), rows * cols, cols + 1

    def field() -> Any:
        return random.random(size + 2 * edge, np.float32)

    def plain() -> Any:
        return random.random(size, np.float32)

    x, one, two, out = field(), plain(), plain(), plain()
    couplings = (field(), field(), field(), field())
    return {
        "coarse_step": (grid_twins, (*couplings, x, field(), one, two, cols)),
        "coarse_left": (grid_twins, (*couplings, x, one, two, out, cols)),
        "move": (transfer_twins, (x, one, random.random(size), two, 0.5, 1.5)),
    }


_AFTER: dict[str, tuple[float, ...]] = {"coarse_step": (0.7,), "coarse_left": ()}


def in_bands(loop: Callable[..., float], arguments: tuple[Any, ...], after: tuple[Any, ...], size: int) -> None:
    """Call a loop for every band of vertices."""
    for start in range(0, size, _BAND):
        loop(*arguments, start, min(start + _BAND, size), *after)


def grid_rows(rows: int, cols: int, repeats: int) -> list[list[str]]:
    """A row of the table for each loop over a grid of this size."""
    size = rows * cols
    out = []
    for name, (twins, arguments) in grid_loops(rows, cols).items():
        after = _AFTER.get(name, (cols + 1,))
        fast, slow = (
            best(partial(in_bands, getattr(loops, name), arguments, after, size), repeats) for loops in (kernels, twins)
        )
        out.append([name, f"{cols}x{rows}", f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"])
    return out


def sweep(
    loop: Callable[..., float], arguments: tuple[Any, ...], ends: list[tuple[int, int]], after: tuple[Any, ...]
) -> None:
    """Call a loop for every band of rows."""
    for first, last in ends:
        loop(*arguments, first, last, *after)


def finest_rows(rows: int, cols: int, repeats: int) -> list[list[str]]:
    """The rows of the sweeps over the finest level, and of what makes the next coarser one."""
    random, size, coarse = np.random.default_rng(0), rows * cols, ((rows + 1) // 2, (cols + 1) // 2)
    width = coarse[1] + 1
    quarter, direction = (np.pad(random.random(size, np.float32), cols + 1) for _ in range(2))
    # small weights: repeated products with A must not overflow
    quarter *= np.float32(0.01)
    step, residual, out = (np.float32(0.01) * random.random(size, np.float32) for _ in range(3))
    x, *ways = (np.pad(random.random(coarse[0] * coarse[1], np.float32), width) for _ in range(9))
    results = tuple(np.zeros_like(x) for _ in range(13))
    unknown, beside = np.ones(size, bool), np.zeros(cols + 1, np.float32)
    finest = quarter, step, residual
    jobs: dict[str, tuple[Any, int, tuple[Any, ...], tuple[Any, ...]]] = {
        "coarsen_finest": (coarsening, coarse[0], ((quarter, step, unknown), results), (False,)),
        "finest_descend": (sweep_twins, coarse[0], (finest, tuple(ways), (x[width:-width],)), (-1 / 3,)),
        "finest_ascend": (sweep_twins, coarse[0], ((*finest, x), tuple(ways), (out,)), (-1 / 3,)),
        "finest_advance": (
            sweep_twins,
            rows,
            ((quarter, step, unknown, beside, beside), (direction, out)),
            (0.5, False),
        ),
    }
    table_rows = []
    for name, (twins, height, arrays, after) in jobs.items():
        at_once = max(1, _BAND * height // size)
        ends = [(first, min(first + at_once, height)) for first in range(0, height, at_once)]
        fast, slow = (
            best(partial(sweep, getattr(loops, name), (*arrays, rows, cols), ends, after), repeats)
            for loops in (kernels, twins)
        )
        table_rows.append([name, f"{cols}x{rows}", f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"])
    return table_rows


def heights_row(rows: int, cols: int, repeats: int) -> list[str]:
    """The row of A z on float64 heights."""
    random = np.random.default_rng(0)
    weight, beta = random.random((rows - 1, cols - 1), np.float32), random.random((rows, cols), np.float32)
    z, at_once = random.random((rows, cols)), max(1, (1 << 16) // cols)
    out = np.empty((at_once, cols))

    def product(loop: Callable[..., float]) -> None:
        for first in range(0, rows, at_once):
            loop(weight, beta, z, out, rows, cols, first, min(first + at_once, rows))

    fast, slow = (best(partial(product, each.system_product), repeats) for each in (kernels, system_twins))
    return ["system_product", f"{cols}x{rows}", f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"]


def pair_row(repeats: int) -> list[str]:
    """The row of the pair sums of the surface filter."""
    random = np.random.default_rng(0)
    start = np.arange(_PATCHES + 1) * _NODES
    places = random.normal(size=(_PATCHES * _NODES, 6)).astype(np.float32) * np.float32(0.3)
    places[:, 0] += np.repeat(np.arange(_PATCHES), _NODES)
    sums = random.random((_PATCHES * _NODES, 4), np.float32)
    near = [np.arange(max(0, p - _REACH), min(_PATCHES, p + _REACH + 1)) for p in range(_PATCHES)]
    indptr = np.concatenate([[0], np.cumsum([len(each) for each in near])])
    out = np.empty((len(places), 28), np.float32)
    arguments = (places, sums, start, indptr, np.concatenate(near), 0, _PATCHES, 6.25, out)
    fast, slow = (best(partial(loops.pair_sums, *arguments), repeats) for loops in (kernels, pair_twins))
    pairs = len(np.concatenate(near)) * _NODES**2
    each = f"{fast / pairs * 1e6:.1f} ns a pair"
    return ["pair_sums", each, f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"]


def pixel_row(repeats: int) -> list[str]:
    """The row of the pixel pair sums of `compose split`."""
    random, margin = np.random.default_rng(0), 4096
    guide = random.random((3, _PIXELS + 2 * margin), np.float32)
    levels, shifts = np.zeros(_CELLS, np.int64), random.integers(-margin, margin, _CELLS)
    out = np.empty((3, _PIXELS), np.float32)
    arguments = (guide, guide[None], levels, shifts, np.zeros(_CELLS, np.float32), margin, margin + _PIXELS, out)
    fast, slow = (best(partial(loops.pixel_sums, *arguments), repeats) for loops in (kernels, pixel_twins))
    each = f"{fast / (_PIXELS * _CELLS) * 1e6:.1f} ns a pair"
    return ["pixel_sums", each, f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("kernels", __doc__)
    report.argument("--repeat", type=int, default=20, help="number of runs; the shortest time counts (default 20)")
    options = report.begin()
    if not kernels.IS_COMPILED:
        raise UsageError("the loops are not compiled; install a C compiler, then run make setup")
    rows = [row for size in SIZES for row in grid_rows(*size, options.repeat)]
    rows += [row for size in SIZES for row in finest_rows(*size, options.repeat)]
    rows += [heights_row(*size, options.repeat) for size in SIZES]
    rows += [pair_row(options.repeat), pixel_row(options.repeat), *file_rows(options.repeat, best)]
    report.end(
        "One thread, in bands as the solver uses them, CPU time in milliseconds; best of several runs.",
        table(["loop", "size", "compiled", "NumPy", "times"], rows),
    )


if __name__ == "__main__":
    main()

"""A pass over the finest level in bands of NumPy, compared with Numba: ``python -m bench.kernels [--write]``.

Numba is not a dependency; if it is not installed, its columns are empty.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.masks import statue
from bench.report import Report
from bench.table import table
from nmaptool.core.arrays import Float32
from nmaptool.core.grid import corner_sum
from nmaptool.solver import QuadSystem
from nmaptool.solver.multigrid.finest import Finest
from nmaptool.solver.multigrid.level import inner, new_field

SIZES = ((900, 1000), (2000, 1800), (4096, 4096))
# as `nmaptool.solver.multigrid.finest.Finest.mixed` computes it
_COMPILED = """
import time
started = time.perf_counter()
import numpy
loaded = time.perf_counter()
import numba
imported = time.perf_counter()

@numba.njit(cache=True, parallel=True, fastmath=True)
def mixed(x, quarter, out):
    rows, cols = x.shape
    for i in numba.prange(1, rows - 1):
        for j in range(1, cols - 1):
            top = x[i - 1, j] + x[i, j]
            low = x[i, j] + x[i + 1, j]
            out[i, j] = (
                quarter[i, j] * (low + x[i, j + 1] + x[i + 1, j + 1])
                + quarter[i, j - 1] * (low + x[i, j - 1] + x[i + 1, j - 1])
                + quarter[i - 1, j] * (top + x[i - 1, j + 1] + x[i, j + 1])
                + quarter[i - 1, j - 1] * (top + x[i - 1, j - 1] + x[i, j - 1])
            )
"""
_ALONE = """
few = numpy.ones((8, 8), numpy.float32)
begun = time.perf_counter()
mixed(few, few, few.copy())
print(imported - loaded, time.perf_counter() - begun)
"""


def best(work: Callable[[], object], repeats: int) -> float:
    """Shortest time in milliseconds."""
    least = np.inf
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - started)
    return least * 1e3


def compiled(folder: Path) -> tuple[Callable[[Float32, Float32, Float32], None], float, float]:
    """The pass by Numba; seconds to import Numba and to finish a first cached call, in a new process."""
    alone = folder / "alone.py"
    alone.write_text(_COMPILED + _ALONE, encoding="utf-8")
    for _ in range(2):  # the first call fills the cache
        stated = subprocess.run([sys.executable, str(alone)], check=True, stdout=subprocess.PIPE, text=True).stdout
    module = folder / "compiled_pass.py"
    module.write_text(_COMPILED, encoding="utf-8")
    found = importlib.util.spec_from_file_location("compiled_pass", module)
    assert found is not None and found.loader is not None
    made = importlib.util.module_from_spec(found)
    sys.modules["compiled_pass"] = made
    found.loader.exec_module(made)
    imported, called = map(float, stated.split())
    return made.mixed, imported, called


def row_of(rows: int, cols: int, numba_pass: Callable[..., None] | None, repeats: int) -> list[str]:
    """Milliseconds of both on one size, with the same inputs and outputs."""
    weight = statue(rows, cols)
    system = QuadSystem(weight, corner_sum(weight).astype(np.float32) / 4, np.zeros((rows + 1, cols + 1), bool))
    finest = Finest(system, np.float32)
    x, out = new_field(finest.shape, np.float32), np.empty(finest.size, np.float32)
    inner(x, finest.shape)[:] = np.random.default_rng(0).normal(size=finest.shape)

    def band(start: int, stop: int) -> None:
        out[start:stop] = finest.mixed(x, start, stop)

    ours = best(lambda: finest.in_bands(band), repeats)
    if numba_pass is None:
        return [f"{cols}x{rows}", f"{ours:.2f}", "", ""]
    grid, quarter, other = inner(x, finest.shape), inner(finest.quarter, finest.shape), np.zeros_like(x)
    theirs = inner(other, finest.shape)
    took = best(lambda: numba_pass(grid, quarter, theirs), repeats)
    apart = np.abs(theirs - out.reshape(finest.shape))[1:-1, 1:-1].max()
    assert apart < 1e-5, apart
    return [f"{cols}x{rows}", f"{ours:.2f}", f"{took:.2f}", f"{ours / took:.2f}"]


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("kernels", __doc__)
    report.argument("--repeat", type=int, default=40, help="number of runs; the shortest time counts (default 40)")
    options = report.begin()
    body = ["One pass of two 2x2 box sums over the finest level in float32, in milliseconds; best of several runs."]
    with tempfile.TemporaryDirectory() as name:
        numba_pass = None
        if importlib.util.find_spec("numba") is None:
            body.append("Numba is not installed.")
        else:
            numba_pass, imported, called = compiled(Path(name))
            body.append(
                f"In a new process, importing Numba takes {imported:.2f} s, the first cached call of this function "
                f"{called:.2f} s."
            )
        rows = [row_of(*size, numba_pass, options.repeat) for size in SIZES]
    body.append(table(["pixels", "bands of NumPy", "Numba", "times"], rows))
    report.end(*body)


if __name__ == "__main__":
    main()

"""Memory bandwidth of the machine, after STREAM: copy and triad by NumPy with one thread per core."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

_COUNT = 1 << 24  # float64: 134 MB an array, beyond any cache
_BLOCK = 1 << 16  # long enough for threads, short enough for both steps of a triad to stay in the cache
_REPEATS = 10

# maps are read as float32 normals, heights are written as float64
MAP_BYTES, HEIGHT_BYTES = 12, 8


@dataclass(frozen=True)
class Bandwidth:
    """Bytes per second."""

    copy: float
    triad: float

    def once(self, pixels: int) -> float:
        """Seconds to read a map of this size once and write its heights once."""
        return (MAP_BYTES + HEIGHT_BYTES) * pixels / self.copy

    def __str__(self) -> str:
        return (
            f"Memory on {os.cpu_count()} threads, after STREAM: copy {self.copy / 1e9:.1f} GB/s, triad "
            f"{self.triad / 1e9:.1f} GB/s. To read a map once ({MAP_BYTES} bytes per pixel) and write its\nheights "
            f"once ({HEIGHT_BYTES}) would take {self.once(900_000) * 1e3:.1f} ms at 1000x900 px and "
            f"{self.once(4096**2) * 1e3:.0f} ms at 4096 px; `x once` is the ratio to that time."
        )


def bandwidth() -> Bandwidth:
    """Measure the best of several passes over arrays of 134 MB."""
    a, b, c = (np.full(_COUNT, value) for value in (0.0, 1.0, 2.0))

    def copy(block: slice) -> None:
        np.copyto(a[block], b[block])

    def triad(block: slice) -> None:
        out = np.multiply(c[block], 3.0, out=a[block])
        np.add(out, b[block], out=out)

    return Bandwidth(16 * _COUNT / _best(copy), 24 * _COUNT / _best(triad))


def _best(work: Callable[[slice], None]) -> float:
    threads = os.cpu_count() or 1
    edges = np.linspace(0, _COUNT // _BLOCK, threads + 1).astype(int) * _BLOCK

    def share(first: int, last: int) -> None:
        for start in range(first, last, _BLOCK):
            work(slice(start, start + _BLOCK))

    taken = []
    with ThreadPoolExecutor(threads) as pool:
        for _ in range(_REPEATS):
            started = time.perf_counter()
            list(pool.map(share, edges[:-1].tolist(), edges[1:].tolist()))
            taken.append(time.perf_counter() - started)
    return min(taken)

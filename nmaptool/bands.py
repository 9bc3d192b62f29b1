"""Large arrays in bands of rows, on all cores: NumPy and OpenCV let other threads run while they compute."""

from __future__ import annotations

import os
from collections.abc import Callable

_MOST_THREADS = 8


def each_band(rows: int, rows_at_once: int, work: Callable[[slice], object]) -> None:
    """Call ``work`` with every band of ``rows``, in no order.

    Parameters
    ----------
    rows : int
    rows_at_once : int
        Of a band; the last may have fewer.
    work : callable
        Given the band as a slice; its bands must not depend on each other. What it raises is raised here.
    """
    bands = [slice(first, min(first + rows_at_once, rows)) for first in range(0, rows, rows_at_once)]
    if len(bands) < 2:
        for band in bands:
            work(band)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(min(os.cpu_count() or 1, _MOST_THREADS, len(bands))) as pool:
        for _ in pool.map(work, bands):
            pass

"""Large arrays in bands of rows, on all cores: NumPy and OpenCV let other threads run while they compute."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TypeVar

_MOST_THREADS = 8
_Task = TypeVar("_Task")
_Result = TypeVar("_Result")


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
    each_of([slice(first, min(first + rows_at_once, rows)) for first in range(0, rows, rows_at_once)], work)


def each_of(
    tasks: Sequence[_Task], work: Callable[[_Task], _Result], most_threads: int = _MOST_THREADS
) -> list[_Result]:
    """What ``work`` gives for each task, in their order; several at a time.

    Parameters
    ----------
    tasks : sequence
        They must not depend on each other.
    work : callable
        What it raises is raised here.
    most_threads : int
        However many cores there are.
    """
    if len(tasks) < 2:
        return [work(task) for task in tasks]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(min(os.cpu_count() or 1, most_threads, len(tasks))) as pool:
        return list(pool.map(work, tasks))

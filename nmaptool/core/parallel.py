"""Work on large arrays in bands of rows, on all cores: NumPy and OpenCV release the GIL while they compute."""

from __future__ import annotations

import contextlib
import contextvars
import itertools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar, cast

if TYPE_CHECKING:
    from concurrent.futures import Future, ThreadPoolExecutor

_MOST_THREADS = 8
_Task = TypeVar("_Task")
_Result = TypeVar("_Result")

_here = threading.local()
_allowed: contextvars.ContextVar[int | None] = contextvars.ContextVar("allowed cores", default=None)


def for_each_band(rows: int, rows_at_once: int, work: Callable[[slice], object]) -> None:
    """Call ``work`` with every band of ``rows``, in any order.

    Parameters
    ----------
    rows : int
    rows_at_once : int
        Rows per band; the last band may have fewer.
    work : callable
        Called with each band as a slice; the bands must not depend on each other. Its exceptions are raised here.
    """
    map_parallel([slice(first, min(first + rows_at_once, rows)) for first in range(0, rows, rows_at_once)], work)


def map_parallel(
    tasks: Sequence[_Task], work: Callable[[_Task], _Result], most_threads: int = _MOST_THREADS
) -> list[_Result]:
    """Call ``work`` with each task, several at a time, and return the results in the order of the tasks.

    A nested call from within ``work`` runs its tasks one by one.

    Parameters
    ----------
    tasks : sequence
        They must not depend on each other.
    work : callable
        If calls fail, the exception of the first failed task is raised here, after all running tasks have ended.
    most_threads : int
        Upper limit for the number of threads, even if there are more cores.
    """
    threads = min(cores(), most_threads, len(tasks))
    if threads < 2 or getattr(_here, "busy", False):
        return [work(task) for task in tasks]
    return _Round(tasks, work).run(threads)


@contextlib.contextmanager
def one_by_one() -> Iterator[None]:
    """Work that this thread starts meanwhile stays in it, so that it leaves the other cores to other threads."""
    before = getattr(_here, "busy", False)
    _here.busy = True
    try:
        yield
    finally:
        _here.busy = before


@contextlib.contextmanager
def at_most(threads: int) -> Iterator[None]:
    """Let work in this context use at most so many cores, so that other processes can use the rest."""
    token = _allowed.set(threads)
    try:
        yield
    finally:
        _allowed.reset(token)


def cores() -> int:
    """Cores that this process may use, or fewer under `at_most`."""
    found, allowed = cores_of_process(), _allowed.get()
    return found if allowed is None else min(found, allowed)


def cores_of_process() -> int:
    """Cores that the system gives this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Round:
    """The tasks of one call. Each free thread takes the next task; so does the calling thread."""

    def __init__(self, tasks: Sequence[_Task], work: Callable[[_Task], _Result]) -> None:
        self._tasks = tasks
        self._work = work
        self._following = itertools.count()  # next() is atomic
        self._stopped = False
        self._errors: dict[int, BaseException] = {}
        self._results: list[object] = [None] * len(tasks)

    def run(self, threads: int) -> list[_Result]:
        others: list[Future[None]] = []
        try:
            with contextlib.suppress(
                RuntimeError
            ):  # no new threads while Python shuts down: the caller does all the work
                pool = _kept.threads()
                for _ in range(threads - 1):
                    others.append(pool.submit(contextvars.copy_context().run, self._take))  # noqa: PERF401 - see above
            self._take()
        finally:
            self._stopped = True  # also after Ctrl-C: running tasks must end before their arrays are freed
            for other in others:
                if not other.cancel():
                    other.result()
        if self._errors:
            raise self._errors[min(self._errors)]
        return cast("list[_Result]", self._results)

    def _take(self) -> None:
        _here.busy = True
        try:
            for number in self._following:
                if self._stopped or number >= len(self._tasks):
                    return
                try:
                    self._results[number] = self._work(self._tasks[number])
                except Exception as error:  # noqa: BLE001 - raised again where the round was called
                    self._errors[number] = error
                    self._stopped = True
        finally:
            _here.busy = False


class _Kept:
    """A pool of worker threads, created on first use."""

    def __init__(self) -> None:
        self._pool: ThreadPoolExecutor | None = None
        self._making = threading.Lock()

    def threads(self) -> ThreadPoolExecutor:
        if self._pool is None:
            from concurrent.futures import ThreadPoolExecutor

            with self._making:
                if self._pool is None:
                    self._pool = ThreadPoolExecutor(max(1, min(cores(), _MOST_THREADS) - 1), "nmaptool")
        return self._pool

    def forget(self) -> None:
        """Start afresh in a forked process, which has none of its parent's threads."""
        self._pool = None
        self._making = threading.Lock()  # another thread may have been holding it
        _here.busy = False


# creating threads takes longer than a pass over a small picture, so they are kept for the next pass
_kept = _Kept()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_kept.forget)

"""Run a set of jobs: many inputs, one command or several, in processes that share the machine or a cluster."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from nmaptool.core.progress import Progress
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.sets.journal import Journal, default_journal
from nmaptool.io.sets.tables import job_of, read_jobs
from nmaptool.options.batch import BatchOptions
from nmaptool.sets import worker as in_worker
from nmaptool.sets.cluster import local_client, remote_client, require_dask
from nmaptool.sets.dispatch import Dispatch
from nmaptool.sets.planning import Shift, shifts, sizes_of
from nmaptool.types.batch import BatchItem, BatchJob, BatchResult


def batch(
    jobs: str | Path | Iterable[Mapping[str, Any] | BatchJob],
    options: BatchOptions | None = None,
    *,
    progress: Progress | None = None,
) -> Iterator[BatchResult]:
    """Run commands for many inputs, several at a time, and go on where an earlier run stopped.

    Each item runs exactly as its command line would, in its own process. What is finished is recorded in a journal
    beside the outputs: a second call skips items whose command, options, version and inputs are the same and whose
    outputs exist. Outputs that an earlier call wrote, and nobody has changed since, are replaced; no others are, unless
    the job says ``overwrite``.

    Parameters
    ----------
    jobs : str, Path, or iterable of mappings
        A table of jobs (.toml, .csv), or for each job a mapping with ``command`` ("relief", "compose convert"),
        ``inputs`` (a file name, a pattern such as ``maps/*.png``, or a list of them), and the options of the command
        by the names of their flags. ``{stem}``, ``{name}``, ``{parent}`` and ``{number}`` in them stand for parts of
        the input's name and its place in the job.
    options : BatchOptions, optional
    progress : callable, optional
        Called with a text such as "3 of 200" and the share of the items that have ended.

    Returns
    -------
    iterator of BatchResult
        In the order in which items end. An item that fails does not stop the others.

    Raises
    ------
    UsageError
        If a job is not accepted, two items have the same output, or Dask is missing.
    InputError
        If a table cannot be read, or no file fits a pattern.
    OutputError
        If another batch uses the same journal.
    ClusterError
        If the processes do not start, or the scheduler goes away.

    Notes
    -----
    New processes import the script that calls this function: its calls belong below ``if __name__ == "__main__":``.

    Examples
    --------
    >>> list(nm.batch([]))
    []
    """
    if isinstance(jobs, str | Path):
        found = read_jobs(jobs)
    else:
        rows = [job if isinstance(job, BatchJob) else dict(job) for job in jobs]
        found = [
            row if isinstance(row, BatchJob) else job_of(row, Path(), f"job {number}")
            for number, row in enumerate(rows, start=1)
        ]
    require_dask()
    items: list[BatchItem] = _command_line().items_of(found)
    return _results(items, options or BatchOptions(), progress)


def _results(items: Sequence[BatchItem], options: BatchOptions, progress: Progress | None) -> Iterator[BatchResult]:
    """Run the items and report how far they are."""
    path = options.journal or default_journal(items)
    ended = 0
    with Journal(path).open() as journal:
        _tell(ended, len(items), progress)
        for result in _Batch(items, options, journal).results():
            ended += 1
            _tell(ended, len(items), progress)
            yield result
    UNFINISHED.kept = ""


def _tell(ended: int, count: int, progress: Progress | None) -> None:
    """Report how many items have ended, also for the message of a run that is interrupted."""
    UNFINISHED.kept = f"{ended} of {count} items have ended; run the same command again to go on"
    if progress is not None and count:
        progress(f"{ended} of {count}", ended / count)


class _Batch:
    """One run of a batch."""

    def __init__(self, items: Sequence[BatchItem], options: BatchOptions, journal: Journal) -> None:
        self._items, self._options, self._journal = items, options, journal

    def results(self) -> Iterator[BatchResult]:
        """Return finished items of earlier runs first, then the others as they end."""
        left: list[int] = []
        for number, item in enumerate(self._items):
            skipped = None if self._options.again else self._journal.finished(item)
            if skipped is None:
                left.append(number)
            else:
                yield skipped
        if not left:
            return
        if self._options.scheduler is not None:
            with remote_client(self._options.scheduler) as client:
                yield from self._run(client, left, None, None)
            return
        for shift in shifts(sizes_of(self._items, left), self._options):
            yield from self._run_here(shift)

    def _run_here(self, shift: Shift) -> Iterator[BatchResult]:
        with UNFINISHED.temporary_folder() as spool, local_client(shift.workers, shift.threads, str(spool)) as client:
            yield from self._run(client, shift.items, shift.threads, spool)

    def _run(
        self, client: Any, numbers: Sequence[int], threads: int | None, spool: Path | None
    ) -> Iterator[BatchResult]:
        with Dispatch(client, self._items, self._begin, threads, spool) as dispatch:
            for number, result in dispatch.results(numbers):
                self._journal.end(self._items[number], result)
                yield result

    def _begin(self, number: int) -> BatchItem:
        """Record that an item begins, and return it as it is to be run."""
        item = self._items[number]
        owned = self._journal.owns(item)
        if owned:
            self._journal.begin(item)
        ready: BatchItem = _command_line().ready(item, overwrite=owned, memory_limit=self._options.memory_limit)
        return ready


def _command_line() -> Any:
    """The module of the command line that knows its flags; the library, below it, cannot import it."""
    return importlib.import_module(in_worker.ITEMS)

"""What runs in a worker process of Dask. Nothing heavy is imported before the first item."""

from __future__ import annotations

import importlib
import os
import signal
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.types.batch import BatchItem, BatchResult

# the command line stands on the library, which therefore only knows the names of its modules
ITEMS, RUN_ITEM = "nmaptool_cli.sets.items", "nmaptool_cli.sets.item"
_RUNNER = "nmaptool_runner"


def dask_setup(worker: Any) -> None:
    """Called by a local worker as it starts: Ctrl-C in a terminal reaches it, too, but only the batch answers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run_item(item: BatchItem, threads: int | None, begun: str | None) -> BatchResult:
    """Run an item in this worker.

    Parameters
    ----------
    item : BatchItem
    threads : int or None
        Cores that it may use. Default: as many as the worker has threads.
    begun : str or None
        File to create first, which tells that this item was running if the process dies.
    """
    from distributed import get_worker

    worker = get_worker()
    kept = vars(worker)
    if _RUNNER not in kept:
        runner = importlib.import_module(RUN_ITEM).ItemRunner(threads or worker.state.nthreads)
        kept.setdefault(_RUNNER, runner)
    return kept[_RUNNER].run(item, None if begun is None else Path(begun))  # type: ignore[no-any-return]


def solvers(dask_worker: Any) -> tuple[int, int]:
    """Return how many solvers this worker has prepared, and how often it reused the last one."""
    runner = vars(dask_worker).get(_RUNNER)
    return (0, 0) if runner is None else (runner.keeper.prepared, runner.keeper.reused)


def forget(dask_worker: Any) -> None:
    """Free what this worker keeps between items, for a cluster that goes on without the batch."""
    vars(dask_worker).pop(_RUNNER, None)


def version() -> str:
    """Return the version of this package on a worker."""
    return __version__


def stop() -> None:
    """Remove the unfinished files of this process and end it."""
    from nmaptool.io.interruption import UNFINISHED

    UNFINISHED.sweep()
    os._exit(0)

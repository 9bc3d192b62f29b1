"""Where the tasks of a run are done: in this process, in local worker processes, or on a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from typing import Any

from nmaptool.core.errors import ClusterError, InputError, LimitError, NmaptoolError, OutputError, reason_of
from nmaptool.core.parallel import one_by_one
from nmaptool.solver.tiling.grid import Tile

# tasks that each worker has waiting, so that it never idles
_WAITING = 2
# a worker that dies takes its task along this often before the run ends
_TRIES = 2
_GO_ON = "what is finished is kept, run again to go on"


class HerePool:
    """Does every task in this process."""

    def each(self, work: Callable[[Tile], object], tiles: Iterable[Tile], done: Callable[[], object]) -> None:
        """Call ``work`` with every tile, and ``done`` as each is finished."""
        for tile in tiles:
            work(tile)
            done()


def _alone(work: Callable[[Tile], object], tile: Tile) -> None:
    """One task on one thread: the other cores have their own tasks."""
    with one_by_one():
        work(tile)


def _distributed() -> Any:
    """The module ``distributed``, which has hardly any types.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        return import_module("distributed")
    except ModuleNotFoundError as error:
        if error.name != "distributed":
            raise
    raise InputError('large maps need the package distributed; install it with: pip install "nmaptool-relief[cluster]"')


class DaskPool:
    """Does tasks on the workers of a Dask cluster. A task is a tile; results are records in the work folder.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def _submit(self, work: Callable[[Tile], object], tile: Tile) -> Any:
        return self._client.submit(_alone, work, tile, pure=False)

    def each(self, work: Callable[[Tile], object], tiles: Iterable[Tile], done: Callable[[], object]) -> None:
        """Call ``work`` with every tile, and ``done`` as each is finished.

        Raises
        ------
        LimitError
            If workers die at the same tile again and again.
        ClusterError
            If there are no workers, or the scheduler goes away.
        """
        from concurrent.futures import CancelledError

        distributed = _distributed()
        gone = distributed.comm.core.CommClosedError, CancelledError, TimeoutError, OSError
        rest = iter(tiles)
        try:
            threads = sum(self._client.nthreads().values())
            if not threads:
                raise ClusterError("the cluster has no workers; start some with `dask worker`, and run again")
            first = [self._submit(work, tile) for _, tile in zip(range(_WAITING * threads), rest, strict=False)]
            running = distributed.as_completed(first)
            try:
                for future in running:
                    error = future.exception()
                    if error is not None:
                        raise _TaskError from error
                    done()
                    following = next(rest, None)
                    if following is not None:
                        running.add(self._submit(work, following))
            except BaseException:
                self._client.cancel(list(running.futures))
                raise
        except _TaskError as failed:
            raise _told(failed.__cause__) from None
        except gone as error:
            raise ClusterError(f"the connection to the scheduler was lost ({type(error).__name__}); {_GO_ON}") from None


class _TaskError(Exception):
    """A task failed; its cause is the error."""


def _told(error: BaseException | None) -> BaseException:
    """The error of a task as the user is to see it."""
    if isinstance(error, _distributed().KilledWorker):
        return LimitError(
            f"workers died {_TRIES + 1} times at one tile, the last {error.last_worker.address}, most likely for "
            f"lack of memory; use fewer `workers`, a smaller `tile` or a larger `memory_limit`; {_GO_ON}"
        )
    if isinstance(error, OSError) and not isinstance(error, NmaptoolError):
        return OutputError(f"a worker cannot write ({reason_of(error)}); {_GO_ON}")
    assert error is not None
    return error


@contextlib.contextmanager
def local_pool(workers: int, memory_bytes: int | None = None) -> Iterator[DaskPool | HerePool]:
    """A pool of processes on this machine, each with one thread.

    Parameters
    ----------
    workers : int
        0 does the work in this process.
    memory_bytes : int, optional
        Memory of each worker; one that needs more is stopped and its task is tried again.
    """
    if workers == 0:
        yield HerePool()
        return
    import dask

    distributed = _distributed()
    quiet = {
        "distributed.scheduler.allowed-failures": _TRIES,
        "distributed.worker.memory.spill": False,
        "distributed.worker.memory.target": False,
    }
    with dask.config.set(quiet):
        try:
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                memory_limit=memory_bytes or 0,
                dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            )
        except (RuntimeError, OSError, TimeoutError) as error:
            raise ClusterError(
                f"worker processes could not be started ({error}); run again, or use `workers=1`"
            ) from None
        with cluster, distributed.Client(cluster) as client:
            yield DaskPool(client)


@contextlib.contextmanager
def cluster_pool(address: str) -> Iterator[DaskPool]:
    """The pool of a running cluster.

    Raises
    ------
    ClusterError
        If it cannot be reached.
    """
    try:
        client = _distributed().Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"`scheduler={address!r}`: cannot be reached ({type(error).__name__}); start one with `dask scheduler`"
        ) from None
    with client:
        yield DaskPool(client)

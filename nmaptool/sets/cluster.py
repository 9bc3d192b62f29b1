"""Clusters of Dask: processes on this machine, or a running scheduler."""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import multiprocessing
import signal
import sys
from collections.abc import Iterator
from multiprocessing import resource_tracker
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import ClusterError, UsageError
from nmaptool.sets import worker as in_worker

_PACKAGES = ("dask", "distributed")
_GUARD = 'new processes import the script that calls batch, so the call belongs below if __name__ == "__main__":'
# glibc keeps the memory of arrays up to 32 MB for the next ones; Dask's variables would give it back to the system
# after every array, and clearing it anew takes a fifth of the time of small maps
_MALLOC = {"MALLOC_MMAP_THRESHOLD_": 32 << 20, "MALLOC_TRIM_THRESHOLD_": 256 << 20, "MALLOC_TOP_PAD_": 64 << 20}
_CONNECT_S, _WORKERS_S = 10, 30


def require_dask() -> None:
    """Refuse to go on without the extra, or in a process that is only just starting.

    Raises
    ------
    UsageError, ClusterError
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # it imports the script that started it
        raise ClusterError(_GUARD)
    lacking = [name for name in _PACKAGES if importlib.util.find_spec(name) is None]
    if lacking:
        raise UsageError(
            f'sets of jobs need {" and ".join(lacking)}; install them with: pip install "nmaptool-relief[cluster]"'
        )


@contextlib.contextmanager
def local_client(workers: int, threads: int, folder: str) -> Iterator[Any]:
    """Start processes on this machine, and end them with the block.

    Parameters
    ----------
    workers : int
    threads : int
        Threads of the libraries in each process; each runs one item at a time.
    folder : str
        For the files of Dask.

    Raises
    ------
    ClusterError
        If they do not start.
    """
    import dask
    from distributed import Client

    # a process that dies fails what it was given at once; the batch itself tries again what was really running
    settings: dict[str, Any] = {
        "distributed.scheduler.allowed-failures": 0,
        "distributed.comm.timeouts.connect": "30s",
        "distributed.worker.profile.enabled": False,  # it would look at every thread a hundred times a second
        "distributed.nanny.pre-spawn-environ": _environment(threads),
    }
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(settings))
        stack.enter_context(_silent())
        try:
            with _without_ctrl_c():
                cluster = stack.enter_context(_processes(workers, folder))
            client = stack.enter_context(Client(cluster))  # type: ignore[no-untyped-call]
        except (OSError, RuntimeError, TimeoutError) as error:
            reason = _first_line(error)
            raise ClusterError(
                f"the worker processes do not start ({reason}); use fewer `workers`, and note that {_GUARD}"
            ) from None
        yield client


def _processes(workers: int, folder: str) -> Any:
    from distributed import LocalCluster

    return LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        memory_limit=0,  # planned beforehand; Dask would pause or end a process at its share
        local_directory=folder,
        silence_logs=logging.CRITICAL,
        preload=[in_worker.__name__],
    )


def _environment(threads: int) -> dict[str, int]:
    """Return the environment variables of the processes, in place of Dask's own."""
    counts = dict.fromkeys(("OMP_NUM_THREADS", "OPENCV_FOR_THREADS_NUM", "OPENIMAGEIO_THREADS"), threads)
    return counts | {"OPENBLAS_NUM_THREADS": 1, "MKL_NUM_THREADS": 1} | _MALLOC


@contextlib.contextmanager
def remote_client(address: str) -> Iterator[Any]:
    """Connect to a running scheduler.

    Raises
    ------
    ClusterError
        If it does not answer, or has no workers with this version of the package.
    """
    from distributed import Client

    with contextlib.ExitStack() as stack:
        stack.enter_context(_silent())
        try:
            client = stack.enter_context(Client(address, timeout=_CONNECT_S))  # type: ignore[no-untyped-call]
        except (OSError, ValueError, RuntimeError, TimeoutError) as error:
            raise ClusterError(
                f"{address}: no scheduler answers ({_first_line(error)}); start one with: dask scheduler"
            ) from None
        try:
            client.wait_for_workers(1, timeout=_WORKERS_S)
        except TimeoutError:
            raise ClusterError(
                f"{address}: the cluster has no workers; start one with: dask worker {address}"
            ) from None
        _check_versions(client, address)
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # whatever is wrong with the connection, it is no longer needed
                client.run(in_worker.forget, on_error="ignore")


def _check_versions(client: Any, address: str) -> None:
    try:
        found = client.run(in_worker.version)
    except Exception as error:  # noqa: BLE001 - whatever the worker raises as it loads the package
        raise ClusterError(
            f"{address}: a worker cannot load nmaptool ({_first_line(error)}); install version {__version__} there"
        ) from None
    for name, version in found.items():
        if version != __version__:
            raise ClusterError(f"{name}: has nmaptool {version}, and this is {__version__}; install the same version")


def _first_line(error: BaseException) -> str:
    return (str(error).strip() or type(error).__name__).splitlines()[0].rstrip(".")


@contextlib.contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Keep Ctrl-C in a terminal from the processes that the block starts: only the batch itself answers it.

    They, and the thread that starts them again after they died, inherit the signals that are blocked. Other threads of
    this process still receive it.
    """
    if sys.platform == "win32":
        yield
        return
    _start_tracker()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_tracker() -> None:
    """Start the process in which Python counts semaphores, without its warning about those of a process that ended."""
    quiet = "ignore:resource_tracker"
    sys.warnoptions.append(quiet)
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(quiet)


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Keep Dask from reporting lost workers itself: the batch reports them."""
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)

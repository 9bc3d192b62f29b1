"""Give items to the workers of a cluster and collect their results."""

from __future__ import annotations

import contextlib
import queue
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Self

from nmaptool.core.errors import ClusterError
from nmaptool.sets import worker as in_worker
from nmaptool.types.batch import BatchItem, BatchResult

# called with the item, the cores that it may use, and the name of the file that says that it has begun
Task = Callable[[BatchItem, int | None, str | None], BatchResult]
# items at each worker, so that none waits for its next one
_AT_EACH = 2
# how often an item is begun whose process dies, and how often an item is sent in all
_ATTEMPTS, _MOST_SENT = 2, 8
_LOOK_S, _PATIENCE_S, _COUNT_S, _ALONE_S = 0.2, 20.0, 5.0, 60.0
_GO_ON = "run the same command again to go on with the other items"


class Dispatch:
    """Items on their way through a cluster.

    Parameters
    ----------
    client : distributed.Client
    items : sequence of BatchItem
    begin : callable
        Called with the number of an item just before it is sent; returns the item to send.
    threads : int or None
        Cores for each item; None for the threads of the worker.
    spool : Path or None
        Folder on this machine in which workers note what they begin; None if they are elsewhere.
    task : callable
        What a worker calls.
    """

    def __init__(
        self,
        client: Any,
        items: Sequence[BatchItem],
        begin: Callable[[int], BatchItem],
        threads: int | None,
        spool: Path | None,
        task: Task = in_worker.run_item,
    ) -> None:
        self._client, self._items, self._begin = client, items, begin
        self._threads, self._spool, self._task = threads, spool, task
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._running: dict[str, tuple[int, Any]] = {}
        self._sent: dict[int, int] = {}
        self._deaths: dict[int, int] = {}
        self._workers, self._counted, self._alone_since = 0, -_COUNT_S, time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._running:
            self._stop()

    def results(self, numbers: Sequence[int]) -> Iterator[tuple[int, BatchResult]]:
        """Run the items of these numbers; return each number with its result, in the order in which they end.

        Raises
        ------
        ClusterError
            If the scheduler goes away.
        """
        waiting = deque(numbers)
        while waiting or self._running:
            while waiting and len(self._running) < _AT_EACH * max(1, self._count()):
                self._send(waiting.popleft())
            future = self._next()
            number, _ = self._running.pop(future.key)
            result = self._result(number, future)
            if result is None:
                waiting.appendleft(number)
            else:
                yield number, result

    def _count(self) -> int:
        """Return the number of workers; those of a cluster may come and go."""
        now = time.monotonic()
        if now - self._counted >= _COUNT_S:
            self._workers, self._counted = len(self._client.nthreads()), now
        return self._workers

    def _send(self, number: int) -> None:
        attempt = self._sent[number] = self._sent.get(number, 0) + 1
        begun = None if self._spool is None else str(self._spool / f"{number}-{attempt}")
        key = f"nmap-{id(self):x}-{number}-{attempt}"
        item = self._begin(number)
        future = self._client.submit(self._task, item, self._threads, begun, key=key, pure=False)
        self._running[key] = number, future
        future.add_done_callback(self._ended.put)

    def _next(self) -> Any:
        """Wait for the next item to end."""
        lost_since = None
        while True:
            with contextlib.suppress(queue.Empty):
                return self._ended.get(timeout=_LOOK_S)
            if self._client.status == "running":
                lost_since = None
                self._require_workers()
                continue
            lost_since = lost_since or time.monotonic()
            if self._client.status == "closed" or time.monotonic() - lost_since > _PATIENCE_S:
                raise self._gone()

    def _require_workers(self) -> None:
        """Wait for new workers only so long."""
        if self._count():
            self._alone_since = time.monotonic()
        elif time.monotonic() - self._alone_since > _ALONE_S:
            raise ClusterError(f"there has been no worker for {_ALONE_S:.0f} s; {_GO_ON}")

    def _result(self, number: int, future: Any) -> BatchResult | None:
        """Return the result of an item; None if it is to be sent again."""
        from distributed.scheduler import KilledWorker

        if future.status == "finished":
            found: BatchResult = future.result()
            return found
        if future.status != "error":  # cancelled or lost
            raise self._gone()
        error = future.exception()
        item = self._items[number]
        if not isinstance(error, KilledWorker):
            text = (str(error).strip() or type(error).__name__).splitlines()[0]
            return _failed(item, f"{item.inputs[0]}: the worker cannot run it ({text})")
        if self._spool is None:  # the scheduler has tried again itself
            return _failed(item, self._died(item))
        if (self._spool / f"{number}-{self._sent[number]}").exists():
            self._deaths[number] = self._deaths.get(number, 0) + 1
        if self._deaths.get(number, 0) >= _ATTEMPTS or self._sent[number] >= _MOST_SENT:
            return _failed(item, self._died(item))
        return None

    def _died(self, item: BatchItem) -> str:
        times = "" if self._spool is None else "twice "
        return (
            f"{item.inputs[0]}: its process ended {times}in the middle (killed, or out of memory); use fewer `workers` "
            "or a smaller map"
        )

    def _gone(self) -> ClusterError:
        return ClusterError(f"the scheduler has gone; {_GO_ON}")

    def _stop(self) -> None:
        """Cancel what waits, and on this machine end what runs and remove its unfinished files."""
        with contextlib.suppress(Exception):
            self._client.cancel([future for _, future in self._running.values()], force=True)
            if self._spool is not None:
                for nanny in self._client.cluster.workers.values():
                    nanny.auto_restart = False
                self._client.run(in_worker.stop, on_error="ignore")


def _failed(item: BatchItem, message: str) -> BatchResult:
    return BatchResult(item.inputs, item.outputs, ClusterError.exit_code, "failed", message, recipe=item.recipe)

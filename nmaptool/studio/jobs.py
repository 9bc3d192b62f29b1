"""Work in the background that the user can cancel: one piece at a time, beside the solver."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from nmaptool.core.errors import NmaptoolError, RendererError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.studio.forms.given import in_words

_T = TypeVar("_T")
# seconds between two messages about progress
_PAUSE_S = 0.1


class _CancelledError(Exception):
    """Ends a job that the user cancelled."""


class Jobs:
    """Runs one job at a time in a thread of its own; a second one is refused meanwhile.

    Messages for the page have the kind of the job, its number, what it does, and a state: ``running`` with the stage
    and the share done, then ``done``, ``cancelled``, or ``failed`` with the reason.

    Parameters
    ----------
    tell : callable
        Sends a message to every window, from any thread.
    later : callable
        Calls a function with an argument in the server's thread, from any thread.
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None], later: Callable[..., None]) -> None:
        self._tell = tell
        self._later = later
        self._number = 0
        self._running: dict[str, Any] | None = None
        self._cancelled = False
        self._thread: threading.Thread | None = None

    @property
    def message(self) -> dict[str, Any] | None:
        """The last message about the job that runs."""
        return self._running

    def start(self, kind: str, what: str, work: Callable[[Progress], _T], then: Callable[[_T], str]) -> None:
        """Start a job.

        Parameters
        ----------
        kind : str
            The kind of its messages.
        what : str
            What it does, such as "bake portrait.ply".
        work : callable
            Called in the job's thread with a function to report progress to.
        then : callable
            Called in the server's thread with the result; returns a line about it.

        Raises
        ------
        UsageError
            If another one runs.
        """
        if self._running is not None:
            running = self._running["what"]
            raise UsageError(f"{what}: the studio is still at work ({running}); wait until it is done, or cancel it")
        self._number += 1
        self._cancelled = False
        self._running = {"kind": kind, "job": self._number, "what": what, "state": "running", "stage": "", "share": 0.0}
        self._tell(self._running)
        self._thread = threading.Thread(target=self._run, args=(work, then), name="studio bake", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """End the job that runs at its next stage."""
        self._cancelled = True

    def stop(self) -> None:
        """End the job and its thread."""
        self._cancelled = True
        if self._thread is not None:
            self._thread.join(timeout=5)

    def _run(self, work: Callable[[Progress], _T], then: Callable[[_T], str]) -> None:
        told = 0.0

        def watch(stage: str, share: float) -> None:
            nonlocal told
            if self._cancelled:
                raise _CancelledError
            now = time.monotonic()
            if self._running is not None and now - told > _PAUSE_S:
                told = now
                self._running = {**self._running, "stage": stage, "share": round(share, 3)}
                self._tell(self._running)

        try:
            result = work(watch)
            watch("done", 1.0)  # cancelled at last
        except _CancelledError:
            self._later(self._end, {"state": "cancelled"})
        except Exception as error:  # noqa: BLE001 - a job must not end without a word
            self._later(self._end, failure(error))
        else:
            self._later(self._finish, then, result)

    def _finish(self, then: Callable[[_T], str], result: _T) -> None:
        """In the server's thread."""
        self._end({"state": "done", "share": 1.0}, lambda: then(result))

    def _end(self, said: dict[str, Any], line: Callable[[], str] | None = None) -> None:
        assert self._running is not None
        message = {**self._running, **said}
        self._running = None  # before the document changes, which shows what runs
        try:
            if line is not None:
                message["text"] = line()
        except NmaptoolError as error:
            message |= failure(error)
        self._tell(message)


def failure(error: Exception) -> dict[str, Any]:
    """Return why something failed, as the page shows it."""
    text = f"this is a bug in nmaptool ({type(error).__name__}: {error}); please report it"
    if isinstance(error, NmaptoolError):
        text = in_words(str(error))
    elif isinstance(error, MemoryError):
        text = "out of memory; use a smaller `size` or mesh"
    return {"state": "failed", "text": " ".join(text.split()), "lacks_renderer": isinstance(error, RendererError)}

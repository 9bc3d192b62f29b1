"""A progress bar on stderr for work that takes longer than a second."""

from __future__ import annotations

import threading
from typing import Any

_AFTER_S = 1.0


class LateBar:
    """A progress bar that appears only after a delay, so that short runs show none."""

    def __init__(self) -> None:
        self._seen = ("reading", 0.0)
        self._bar: Any = None
        self._ended = False
        self._lock = threading.Lock()
        self._timer = threading.Timer(_AFTER_S, self._show)
        self._timer.daemon = True
        self._timer.start()

    def report(self, word: str, share: float) -> None:
        """Update the name of the stage and the share that is done."""
        with self._lock:
            self._seen = word, share
            if self._bar is not None:
                self._bar.update(0, description=word, completed=share)

    def stop(self) -> None:
        """Remove the bar."""
        self._timer.cancel()
        with self._lock:
            self._ended = True
            if self._bar is not None:
                self._bar.stop()

    def _show(self) -> None:
        from rich import progress
        from rich.console import Console

        columns = (progress.TextColumn("{task.description:<12}"), progress.BarColumn(), progress.TimeElapsedColumn())
        bar = progress.Progress(*columns, console=Console(stderr=True), transient=True)
        with self._lock:
            if not self._ended:
                word, share = self._seen
                bar.update(bar.add_task(word, total=1.0), completed=share)
                bar.start()
                self._bar = bar

"""Short work in the background, one piece after the other, such as reading a depth picture."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from nmaptool.composition.recipe_values import with_recipe_keys
from nmaptool.core.errors import NmaptoolError
from nmaptool.core.progress import Progress
from nmaptool.studio.files.store import Store
from nmaptool.studio.windows import Message, Windows

_T = TypeVar("_T")


class _EndedError(Exception):
    """Ends work: the studio closes."""


class Background:
    """A thread for work that the user does not wait for.

    Parameters
    ----------
    windows : Windows
        Are told of progress and errors.
    store : Store
        Whose files errors may name.
    """

    def __init__(self, windows: Windows, store: Store) -> None:
        self._windows = windows
        self._store = store
        self._pool = ThreadPoolExecutor(1, "studio background")
        self._ends = False

    def start(self, work: Callable[[Progress], _T], then: Callable[[_T], None]) -> None:
        """Do work after what was started before, and call ``then`` with its result in the server's thread.

        ``work`` gets a function to report its progress to; errors of both are shown in every window.
        """

        def watch(stage: str, share: float) -> None:
            if self._ends:
                raise _EndedError
            self._windows.tell_later({"kind": "progress", "stage": stage, "share": share})

        def run() -> None:
            try:
                result = work(watch)
            except _EndedError:
                return
            except NmaptoolError as error:
                self._windows.tell_later(error_message(error, self._store))
            else:
                self._windows.later(finish, result)

        def finish(result: _T) -> None:
            try:
                then(result)
            except NmaptoolError as error:
                self._windows.tell(error_message(error, self._store))

        self._pool.submit(run)

    def stop(self) -> None:
        """End the work and the thread."""
        self._ends = True
        self._pool.shutdown(wait=True, cancel_futures=True)


def error_message(error: NmaptoolError, store: Store) -> Message:
    """Return the message that shows an error, with options named as in recipes, and files as the user knows them."""
    return {"kind": "error", "text": with_recipe_keys(store.named(str(error)))}

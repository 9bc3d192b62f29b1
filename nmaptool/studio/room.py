"""One open document: its history, its solver, and the windows that show it."""

from __future__ import annotations

import asyncio
import dataclasses
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from nmaptool.composition.recipe_parsing import with_recipe_keys
from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import NmaptoolError
from nmaptool.core.progress import Progress
from nmaptool.options import DepthOptions, SolidOptions
from nmaptool.studio.controls import controls, plain, plain_options
from nmaptool.studio.descriptions import forms
from nmaptool.studio.document import Document, History
from nmaptool.studio.engine import has_parts, uses_width
from nmaptool.studio.inspector import Inspector
from nmaptool.studio.layers import described
from nmaptool.studio.store import Store
from nmaptool.studio.worker import Worker

_T = TypeVar("_T")
Message: TypeAlias = dict[str, Any]
# options that the page applies to the parts of the heights, or that only an export uses
_LOCAL = ("delta", "fit", "height", "width", *(f.name for f in dataclasses.fields(SolidOptions)))
# messages that a window has not yet taken; older ones are dropped
_MOST_WAITING = 64


class _EndedError(Exception):
    """Ends work in the background: the studio closes."""


class Window:
    """A page that shows the document: the messages that wait for it."""

    def __init__(self) -> None:
        self.waiting: asyncio.Queue[bytes | Message] = asyncio.Queue()

    def put(self, message: bytes | Message) -> None:
        """Add a message; the oldest is dropped if a slow page lets them pile up."""
        while self.waiting.qsize() >= _MOST_WAITING:
            self.waiting.get_nowait()
        self.waiting.put_nowait(message)


class Room:
    """A document that several windows may show.

    Its methods are called in the thread of the server, except `tell_later`.

    Parameters
    ----------
    document : Document
    path : Path or None
        The recipe that it was read from and is saved to.
    store : Store
        Where dropped, baked and painted files are kept.
    """

    def __init__(self, document: Document, path: Path | None, store: Store) -> None:
        self.history = History(document)
        self.path = path
        self.store = store
        # what layers were made from in this run, by the path of their map
        self.depths: dict[str, tuple[Path, DepthOptions]] = {}
        # the last painted pictures, (H, W) float32, by the path of their file
        self.painted: dict[str, Float32] = {}
        self._saved = document if path is not None else Document(folder=document.folder)
        self._windows: set[Window] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._latest: bytes | Message | None = None  # heights, or why there are none
        self._placements: Message | None = None
        self._joining: object = None
        self._lock = threading.Lock()
        self._worker = Worker(self._from_worker)
        self._inspector = Inspector(self._from_worker)
        self._jobs = ThreadPoolExecutor(1, "studio job")
        self._solved: Document | None = None
        self._ends = False
        self._solve()
        self._inspector.look(document)

    @property
    def now(self) -> Document:
        """The document as it is."""
        return self.history.now

    @property
    def is_saved(self) -> bool:
        """Whether the file holds the document as it is."""
        return self.now == self._saved

    @property
    def motif(self) -> Mask | None:
        """(H, W) bool: where the composed map has its motif; None if no map has been read."""
        return self._worker.motif

    def enter(self, window: Window) -> None:
        """Show the document in a window."""
        self._loop = asyncio.get_running_loop()
        self._windows.add(window)
        window.put({"kind": "controls", "controls": controls()})
        window.put(forms())
        window.put(self.state())
        with self._lock:
            for message in (self._placements, self._latest, self._inspector.message(self.now)):
                if message is not None:
                    window.put(message)

    def leave(self, window: Window) -> None:
        """A window was closed."""
        self._windows.discard(window)

    def close(self) -> None:
        """End the threads."""
        self._ends = True
        self._jobs.shutdown(wait=True, cancel_futures=True)
        self._inspector.stop()
        self._worker.stop()

    def state(self) -> Message:
        """Return the document as the page shows it."""
        now, (undo, redo) = self.now, self.history.steps
        values = {**vars(now.options), **vars(now.solid)}
        return {
            "kind": "state",
            "name": now.name if self.path is None else self.path.name,
            "path": None if self.path is None else str(self.path),
            "is_saved": self.is_saved,
            "values": {control["name"]: plain(values[control["name"]]) for control in controls()},
            "layers": described(now.layers),
            "files": vars(now.relief.files),
            "depths": {file: plain_options(options) for file, (_, options) in self.depths.items()},
            "undo": undo,
            "redo": redo,
        }

    def do(self, document: Document, *, joining: object = None) -> None:
        """Take a changed document, show it everywhere and solve it.

        Parameters
        ----------
        document : Document
        joining : object
            Changes in a row with the same value, other than None, are one step to undo, as while a slider moves.
        """
        if document == self.now:
            self._joining = joining
            return
        self.history.do(document, joined=joining is not None and joining == self._joining)
        self._joining = joining
        self.show()

    def rest(self) -> None:
        """The hand rests: the next change is a step of its own."""
        self._joining = None

    def step(self, moved: bool) -> None:
        """Show the document after a step back or forward, if there was one."""
        self._joining = None
        if moved:
            self.show()

    def saved(self, document: Document, path: Path) -> None:
        """The document, under the names of the files it was saved with, is in ``path`` now."""
        self.history.now = self._saved = document
        self.path = path
        self._joining = None
        self.show()

    def show(self) -> None:
        """Show the document in every window, and solve it if the page cannot compute it from the parts."""
        self._solve()
        self.tell(self.state())
        self._inspector.look(self.now)

    def tell(self, message: bytes | Message) -> None:
        """Send a message to every window."""
        for window in self._windows:
            window.put(message)

    def tell_later(self, message: bytes | Message) -> None:
        """Send a message to every window, from any thread."""
        self._later(self.tell, message)

    def start(self, work: Callable[[Progress], _T], then: Callable[[_T], None]) -> None:
        """Do work in the background, one after the other, and call ``then`` with its result in the server's thread.

        ``work`` gets a function to report its progress to; errors of both are shown in every window.
        """

        def watch(stage: str, share: float) -> None:
            if self._ends:
                raise _EndedError
            self.tell_later({"kind": "progress", "stage": stage, "share": share})

        def run() -> None:
            try:
                result = work(watch)
            except _EndedError:
                return
            except NmaptoolError as error:
                self.tell_later(error_message(error))
            else:
                self._later(finish, result)

        def finish(result: _T) -> None:
            try:
                then(result)
            except NmaptoolError as error:
                self.tell(error_message(error))

        self._jobs.submit(run)

    def _later(self, call: Callable[..., None], *arguments: object) -> None:
        loop = self._loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(call, *arguments)

    def _solve(self) -> None:
        needs = _needs(self.now)
        if needs == self._solved:
            return
        self._solved = needs
        if self.now.layers:
            self._worker.want(self.now)

    def _from_worker(self, message: bytes | Message) -> None:
        """Called in the solver's thread."""
        with self._lock:
            if isinstance(message, bytes) or message["kind"] == "error":
                self._latest = message
            elif message["kind"] == "placements":
                self._placements = message
        self.tell_later(message)


def error_message(error: NmaptoolError) -> Message:
    """Return the message that shows an error, with options named as in recipes."""
    return {"kind": "error", "text": with_recipe_keys(str(error))}


def _needs(document: Document) -> Document:
    """Return what the heights that the page gets depend on."""
    try:
        if not has_parts(document.options):
            return document
        local = [name for name in _LOCAL if name != "width" or not uses_width(document)]
        return document.changed(dict.fromkeys(local))
    except NmaptoolError:  # options that contradict each other without the others
        return document

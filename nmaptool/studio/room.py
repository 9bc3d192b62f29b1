"""One open document: its history, its solver, and the windows that show it."""

from __future__ import annotations

import asyncio
import dataclasses
import threading
from collections.abc import Mapping
from pathlib import Path

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import NmaptoolError
from nmaptool.options import DepthOptions, SolidOptions
from nmaptool.studio.background import Background
from nmaptool.studio.document import Document, History
from nmaptool.studio.engine import has_parts, uses_width
from nmaptool.studio.files import recovery
from nmaptool.studio.files.export import formats
from nmaptool.studio.files.exports import Exports
from nmaptool.studio.files.store import Store
from nmaptool.studio.forms.controls import controls
from nmaptool.studio.forms.descriptions import forms, plain, plain_options
from nmaptool.studio.forms.plates import plate_line
from nmaptool.studio.forms.presets import Presets
from nmaptool.studio.forms.reasons import reasons
from nmaptool.studio.inspector import Inspector
from nmaptool.studio.layers import described
from nmaptool.studio.meshes.sources import Sources
from nmaptool.studio.windows import Message, Window, Windows
from nmaptool.studio.worker import Worker

# options that the page applies to the parts of the heights, or that only an export uses
_LOCAL = ("delta", "fit", "height", "width", *(f.name for f in dataclasses.fields(SolidOptions)))
# seconds between two messages about the document while a control moves
_TELL_S = 0.15
# seconds from a change until the document is kept for recovery
_KEEP_S = 1.0


class Room:
    """A document that several windows may show.

    Its methods are called in the thread of the server.

    Parameters
    ----------
    document : Document
    store : Store
        Where dropped, baked and painted files are kept.
    presets : Presets
    """

    def __init__(self, document: Document, store: Store, presets: Presets) -> None:
        self.history = History(document)
        self.store = store
        self.presets = presets
        # what layers were made from in this run, by the path of their map
        self.depths: dict[str, tuple[Path, DepthOptions]] = {}
        # the last painted pictures, (H, W) float32, by the path of their file
        self.painted: dict[str, Float32] = {}
        self._start = document
        self._saved = document if document.path is not None else Document(folder=document.folder)
        self.windows = Windows()
        self.sources = Sources(store, self.windows, lambda: self.now)
        self._latest: bytes | Message | None = None  # heights, or why there are none
        self._placements: Message | None = None
        self._joining: object = None
        self._keeping: asyncio.TimerHandle | None = None
        self._telling: asyncio.TimerHandle | None = None
        self._lock = threading.Lock()
        self.worker = Worker(self._from_worker)
        self._inspector = Inspector(self._from_worker)
        self.background = Background(self.windows, store)
        self.exports = Exports(store, self.windows.put_later)
        self._solved: Document | None = None
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
    def has_unsaved(self) -> bool:
        """Whether work would be lost without the file."""
        return bool(self.now.layers) and self.now not in (self._saved, self._start)

    @property
    def motif(self) -> Mask | None:
        """(H, W) bool: where the composed map has its motif; None if no map has been read."""
        return self.worker.motif

    def map_shape(self, place: tuple[int, ...]) -> tuple[int, int] | None:
        """Rows and columns of the map of a layer; None if it is hidden or has none."""
        known = () if self._placements is None else self._placements["layers"]
        return next(((one["rows"], one["cols"]) for one in known if tuple(one["place"]) == place), None)

    def enter(self, window: Window) -> None:
        """Show the document in a window."""
        self.windows.enter(window)
        window.put({"kind": "controls", "controls": controls()})
        window.put(forms())
        window.put({"kind": "formats", "formats": formats()})
        window.put(self.presets.message())
        window.put(self.state())
        with self._lock:
            for message in (self.unsaved(), self._placements, self._latest, self._inspector.message(self.now)):
                if message is not None:
                    window.put(message)
        for greeting in self.sources.greetings(self.now):
            window.put(greeting)

    def leave(self, window: Window) -> None:
        """A window was closed."""
        self.windows.leave(window)
        self.exports.cancel(window)

    def close(self) -> None:
        """End the threads; keep what is not saved."""
        for timer in (self._keeping, self._telling):
            if timer is not None:
                timer.cancel()
        self._keep()
        self.sources.stop()
        self.exports.close()
        self.background.stop()
        self._inspector.stop()
        self.worker.stop()

    def state(self) -> Message:
        """Return the document as the page shows it."""
        now, (undo, redo) = self.now, self.history.steps
        values = {**vars(now.options), **vars(now.solid)}
        return {
            "kind": "state",
            "name": now.name if now.path is None else now.path.name,
            "path": None if now.path is None else str(now.path),
            "is_saved": self.is_saved,
            "values": {control["name"]: plain(values[control["name"]]) for control in controls()},
            "reasons": reasons(now),
            "layers": described(now.layers),
            "files": vars(now.relief.files),
            "plate": plate_line(now),
            "depths": {file: plain_options(options) for file, (_, options) in self.depths.items()},
            "undo": undo,
            "redo": redo,
        }

    def unsaved(self) -> Message:
        """Return the message that offers unsaved work of studios that no longer run."""
        found = recovery.found(self.store.folder.parent, self.store.folder)
        items = [{"id": one.folder.name, "name": one.name, "time": one.time} for one in found]
        return {"kind": "unsaved", "items": items}

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
        document = self.sources.followed(self.now, document)
        self.history.do(document, joined=joining is not None and joining == self._joining)
        self._joining = joining
        self.show()

    def rest(self) -> None:
        """The hand rests: the next change is a step of its own."""
        self._joining = None
        if self._telling is not None:
            self._tell()

    def step(self, moved: bool) -> None:
        """Show the document after a step back or forward, if there was one."""
        self._joining = None
        if moved:
            self.show()

    def saved(self, document: Document, path: Path, copies: Mapping[Path, Path]) -> None:
        """The document was saved in ``path``, with the copies of files that it names now."""
        self.history.moved(self.now.path, path)
        self.history.now = self._saved = dataclasses.replace(document, path=path)
        for source, target in copies.items():
            if str(source) in self.depths:
                self.depths[str(target)] = self.depths[str(source)]
            if str(source) in self.painted:
                self.painted[str(target)] = self.painted[str(source)]
        self.sources.moved(copies)
        self._joining = None
        self.show()

    def opened(self, document: Document) -> None:
        """A recipe was opened."""
        self._saved = document
        self.do(document)

    @property
    def saved_files(self) -> tuple[str, ...]:
        """The files that the document named when it was saved."""
        return self._saved.files

    def show(self) -> None:
        """Solve the document if the page cannot compute it from the parts, show it in every window, and keep it.

        While a control moves, windows are told a few times a second.
        """
        self._solve()
        loop = self.windows.loop
        if self._joining is None or loop is None:
            self._tell()
        elif self._telling is None:
            self._telling = loop.call_later(_TELL_S, self._tell)
        self._keep_soon()

    def _tell(self) -> None:
        """Tell every window what the document is."""
        if self._telling is not None:
            self._telling.cancel()
            self._telling = None
        self.windows.tell(self.state())
        self.windows.tell(self.sources.message(self.now))
        self._inspector.look(self.now)

    def _keep_soon(self) -> None:
        if self.windows.loop is not None and self._keeping is None:
            self._keeping = self.windows.loop.call_later(_KEEP_S, self._keep)

    def _keep(self) -> None:
        """Write the document to the store, unless it is saved."""
        self._keeping = None
        if not self.has_unsaved:
            recovery.forget(self.store)
        else:
            recovery.keep(self.store, self.now)

    def _solve(self) -> None:
        needs = _needs(self.now)
        if needs == self._solved:
            return
        self._solved = needs
        if self.now.layers:
            self.worker.want(self.now, is_moving=self._joining is not None)

    def _from_worker(self, message: bytes | Message) -> None:
        """Called in the solver's thread."""
        if not isinstance(message, bytes) and "text" in message:
            message = {**message, "text": self.store.named(message["text"])}
        with self._lock:
            if isinstance(message, bytes) or message["kind"] == "error":
                self._latest = message
            elif message["kind"] == "placements":
                self._placements = message
        self.windows.tell_later(message)


def _needs(document: Document) -> Document:
    """Return what the heights that the page gets depend on."""
    document = dataclasses.replace(document, path=None, plate=None)  # the stage does not show the plate
    try:
        if not has_parts(document.options):
            return document
        local = [name for name in _LOCAL if name != "width" or not uses_width(document)]
        return document.changed(dict.fromkeys(local))
    except NmaptoolError:  # options that contradict each other without the others
        return document

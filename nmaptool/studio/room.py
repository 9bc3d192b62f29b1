"""One open document: its history, its solver, and the windows that show it."""

from __future__ import annotations

import asyncio
import dataclasses
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, NmaptoolError, UsageError
from nmaptool.io.recipes.writer import write_recipe
from nmaptool.options import SolidOptions
from nmaptool.studio.controls import controls, plain
from nmaptool.studio.document import Document, History
from nmaptool.studio.engine import has_parts
from nmaptool.studio.worker import Worker
from nmaptool.types.recipe import Entry, Recipe, RecipeLayer

# options that the page applies to the parts of the heights, or that only an export uses
_LOCAL = ("delta", "fit", "height", "width", *(f.name for f in dataclasses.fields(SolidOptions)))
# frames that a window has not yet taken; older ones are dropped
_MOST_WAITING = 8


class Window:
    """A page that shows the document: the messages that wait for it."""

    def __init__(self) -> None:
        self.waiting: asyncio.Queue[bytes | dict[str, Any]] = asyncio.Queue()

    def put(self, message: bytes | dict[str, Any]) -> None:
        """Add a message; the oldest is dropped if a slow page lets them pile up."""
        while self.waiting.qsize() >= _MOST_WAITING:
            self.waiting.get_nowait()
        self.waiting.put_nowait(message)


class Room:
    """A document that several windows may show.

    Parameters
    ----------
    document : Document
    """

    def __init__(self, document: Document) -> None:
        self.history = History(document)
        self._saved = document if document.path is not None else None
        self._windows: set[Window] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._latest: bytes | dict[str, Any] | None = None  # heights, or why there are none
        self._moving: tuple[str, ...] = ()
        self._lock = threading.Lock()
        self._worker = Worker(self._from_worker)
        self._solved = _needs(document)
        self._worker.want(document)

    def enter(self, window: Window) -> None:
        """Show the document in a window."""
        self._loop = asyncio.get_running_loop()
        self._windows.add(window)
        window.put({"kind": "controls", "controls": controls()})
        window.put(self.state())
        with self._lock:
            if self._latest is not None:
                window.put(self._latest)

    def leave(self, window: Window) -> None:
        """A window was closed."""
        self._windows.discard(window)

    def close(self) -> None:
        """End the solver."""
        self._worker.stop()

    def state(self) -> dict[str, Any]:
        """Return the document as the page shows it."""
        now, (undo, redo) = self.history.now, self.history.steps
        values = {**vars(now.options), **vars(now.solid)}
        return {
            "kind": "state",
            "name": now.recipe.name if now.path is None else now.path.name,
            "path": None if now.path is None else str(now.path),
            "is_saved": now == self._saved,
            "values": {control["name"]: plain(values[control["name"]]) for control in controls()},
            "layers": [_name(layer) for layer in now.recipe.layers],
            "undo": undo,
            "redo": redo,
        }

    def take(self, message: Mapping[str, Any]) -> dict[str, Any] | None:
        """Do what a page asks; return an answer for that page alone."""
        try:
            match message.get("do"):
                case "set":
                    self._set(message)
                case "undo":
                    self._step(self.history.undo())
                case "redo":
                    self._step(self.history.redo())
                case "save":
                    return self._save(message)
                case other:
                    raise UsageError(f"the page asked for {other!r}, which this version does not know; reload it")
        except NmaptoolError as error:
            return {"kind": "error", "text": str(error)}
        return None

    def _set(self, message: Mapping[str, Any]) -> None:
        values = message.get("values")
        if not isinstance(values, Mapping):
            raise UsageError("the page sent no values; reload it")
        moving = tuple(sorted(values)) if message.get("moving") else ()
        document = self.history.now.changed(values)
        changed = document != self.history.now
        self.history.do(document, joined=bool(moving) and moving == self._moving)
        self._moving = moving
        if changed:
            self._tell()

    def _step(self, moved: bool) -> None:
        self._moving = ()
        if moved:
            self._tell()

    def _tell(self) -> None:
        """Show the changed document in every window, and solve it if the page cannot compute it from the parts."""
        now = self.history.now
        needs = _needs(now)
        if needs != self._solved:
            self._solved = needs
            self._worker.want(now)
        for window in self._windows:
            window.put(self.state())

    def _save(self, message: Mapping[str, Any]) -> dict[str, Any]:
        now = self.history.now
        name = message.get("name")
        path = now.path
        if isinstance(name, str) and name:
            path = now.folder / Path(name).name
            if path.suffix != ".toml":
                path = path.with_name(f"{path.name}.toml")
        if path is None:
            raise UsageError("give the recipe a name to save it under, such as medal.toml")
        replaces = path == now.path or message.get("overwrite") is True
        if path.exists() and not replaces:
            raise InputError(f"{path.name}: exists already; choose another name, or replace it")
        write_recipe(now.recipe, path, overwrite=replaces)
        self.history.now = self._saved = Document(now.recipe, path)
        for window in self._windows:
            window.put(self.state())
        return {"kind": "saved", "path": str(path)}

    def _from_worker(self, message: bytes | dict[str, Any]) -> None:
        """Called in the solver's thread."""
        with self._lock:
            if isinstance(message, bytes) or message["kind"] == "error":
                self._latest = message
        loop = self._loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(self._show, message)

    def _show(self, message: bytes | dict[str, Any]) -> None:
        for window in self._windows:
            window.put(message)


def _needs(document: Document) -> Recipe:
    """Return what the heights that the page gets depend on."""
    return document.changed(dict.fromkeys(_LOCAL)).recipe if has_parts(document.options) else document.recipe


def _name(layer: Entry) -> str:
    return layer.options.name or (layer.file if isinstance(layer, RecipeLayer) else layer.label)

"""The thread that solves: the newest request wins."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from nmaptool.composition.recipe_values import with_recipe_keys
from nmaptool.core.arrays import Mask
from nmaptool.core.errors import NmaptoolError
from nmaptool.io.recipes.stacks import PictureCache
from nmaptool.studio.document import Document
from nmaptool.studio.engine import PREVIEW_PX, QUICK_PX, Engine
from nmaptool.studio.frames import frame_of
from nmaptool.studio.placements import placements

# when a hand has not moved for so long, finer grids are solved, in the end the full one
_PAUSE_S, _REST_S = 0.12, 0.3
# a machine that takes longer for a preview gets a quicker one while a control moves
_SLOW_S = 0.02

Send = Callable[[bytes | dict[str, Any]], None]


class _SupersededError(Exception):
    """Ends a solve whose result is no longer wanted."""


class Worker:
    """Solves documents one after the other in a thread of its own.

    Parameters
    ----------
    send : callable
        Called in the worker's thread with each frame, and with messages for the page.
    """

    def __init__(self, send: Send) -> None:
        self._send = send
        self._changed = threading.Condition()
        self._wanted: tuple[int, Document, bool] | None = None
        self._number = 0
        self._ends = False
        self._engine: Engine | None = None
        self._maps = 0  # engines so far: the page asks again for what it shows of the maps
        self._pictures = PictureCache()
        self._preview_s = 0.0  # seconds that the last preview took
        self._thread = threading.Thread(target=self._run, name="studio solver", daemon=True)
        self._thread.start()

    @property
    def motif(self) -> Mask | None:
        """(H, W) bool: where the composed map has its motif; None before it has been read."""
        engine = self._engine
        return None if engine is None else engine.scene.composition.normal_map.foreground

    def want(self, document: Document, *, is_moving: bool = False) -> int:
        """Ask for the heights of a document, while a control moves or after; return the number of the request."""
        with self._changed:
            self._number += 1
            self._wanted = self._number, document, is_moving
            self._changed.notify()
            return self._number

    def engine_of(self, document: Document) -> Engine | None:
        """Return the engine that has the maps of a document; None while they are read."""
        engine = self._engine
        return engine if engine is not None and engine.fits(document) else None

    def stop(self) -> None:
        """End the thread; a solve that is under way is given up."""
        with self._changed:
            self._ends = True
            self._number += 1
            self._changed.notify()
        self._thread.join(timeout=5)

    def _run(self) -> None:
        while True:
            with self._changed:
                while self._wanted is None and not self._ends:
                    self._changed.wait()
                if self._ends:
                    return
                assert self._wanted is not None
                number, document, is_moving = self._wanted
                self._wanted = None
            try:
                self._answer(number, document, is_moving)
            except _SupersededError:
                continue
            except NmaptoolError as error:
                self._send({"kind": "error", "request": number, "text": with_recipe_keys(str(error))})

    def _answer(self, number: int, document: Document, is_moving: bool) -> None:
        if self._engine is None or not self._engine.fits(document):
            self._send({"kind": "progress", "stage": "reading", "share": 0.0})
            self._engine = Engine(document, self._pictures, self._engine)
            self._pictures.forget()
            self._maps += 1
            self._send(placements(self._engine.scene))
        engine = self._engine
        grids: list[tuple[int | None, float]] = [(PREVIEW_PX, _PAUSE_S), (None, _REST_S)]
        if is_moving and self._preview_s > _SLOW_S:
            grids.insert(0, (QUICK_PX, 0.0))
        shown = None
        for longest, rest in grids:
            with self._changed:
                while shown and self._number == number and (left := shown + rest - time.monotonic()) > 0:
                    self._changed.wait(left)
            if shown and self._number != number:
                return
            self._solve(engine, number, document, longest)
            if engine.is_whole(longest):
                return
            shown = shown or time.monotonic()

    def _solve(self, engine: Engine, number: int, document: Document, longest: int | None) -> None:
        def watch(stage: str, share: float) -> None:
            # a preview is finished: if each event of a drag ended it, no picture would be seen before the hand rests
            if self._ends or (self._number != number and longest is None):
                raise _SupersededError
            if longest is None:
                self._send({"kind": "progress", "stage": stage, "share": share})

        watch("setting up", 0.0)
        started = time.perf_counter()
        parts = engine.parts(document.options, longest=longest, progress=watch)
        seconds = time.perf_counter() - started
        if longest == PREVIEW_PX:
            self._preview_s = seconds
        facts = {
            "request": number,
            "full": engine.size,
            "maps": self._maps,
            "is_full": engine.is_whole(longest),
            "seconds": round(seconds, 4),
        }
        if self._number == number or longest is not None:
            self._send(frame_of(parts, facts))

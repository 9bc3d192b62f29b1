"""Exports in the background: one at a time, each in a thread of its own, with progress and a way to end it."""

from __future__ import annotations

import os
import secrets
import shutil
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nmaptool.core.errors import NmaptoolError, UsageError
from nmaptool.core.parallel import one_by_one
from nmaptool.studio.document import Document
from nmaptool.studio.engine import Engine
from nmaptool.studio.files.estimates import estimate
from nmaptool.studio.files.export import Wanted, export
from nmaptool.studio.files.store import Store, plain_name

# seconds between two messages about the same stage
_BETWEEN_S = 0.1
# the system gives other threads the processor first
_NICENESS = 10

Say = Callable[[Any, dict[str, Any]], None]


class _EndedError(Exception):
    """Ends an export or an estimate that is no longer wanted."""


@dataclass
class Job:
    """One export: who asked for it, its file, and whether it is to end."""

    window: object
    root: Path
    name: str
    id: str = field(default_factory=lambda: secrets.token_urlsafe(12))
    is_ended: bool = False
    is_done: bool = False

    @property
    def path(self) -> Path:
        """Its file, in a folder of its own, so that it has the name that the user expects."""
        return self.root / f"export-{self.id}" / self.name

    def forget(self) -> None:
        """Delete the file."""
        shutil.rmtree(self.path.parent, ignore_errors=True)

    def message(self, state: str, **more: Any) -> dict[str, Any]:
        """A message about it for the page."""
        return {"kind": "export", "id": self.id, "state": state, **more}


class Exports:
    """Makes files of a document for the pages that show it.

    Parameters
    ----------
    store : Store
        Where the files lie until the browser has them.
    say : callable
        Called from any thread with a window and a message for it.
    """

    def __init__(self, store: Store, say: Say) -> None:
        self._store = store
        self._say = say
        self._lock = threading.Lock()
        self._job: Job | None = None
        self._thread: threading.Thread | None = None
        self._estimating = threading.Lock()
        self._number = 0

    def begin(self, window: object, document: Document, wanted: Wanted, stem: str) -> dict[str, Any]:
        """Begin an export; return the message that says so.

        Raises
        ------
        UsageError
            If one is under way.
        """
        with self._lock:
            if self._job is not None and not self._job.is_done:
                raise UsageError("another export is under way; wait until it has ended, or cancel it")
            if self._job is not None:
                self._job.forget()  # in case no browser fetched it
            job = self._job = Job(window, self._store.folder, plain_name(f"{stem}{wanted.ending}"))
            self._thread = threading.Thread(
                target=self._run, args=(job, document, wanted), name="studio export", daemon=True
            )
            self._thread.start()
        return job.message("begun", name=job.name)

    def cancel(self, window: object) -> None:
        """End the export that a window asked for, if it is under way."""
        with self._lock:
            if self._job is not None and self._job.window is window:
                self._job.is_ended = True

    def take(self, name: str) -> Job | None:
        """Return the export with this id if its file is there."""
        with self._lock:
            job = self._job
            if job is None or not job.is_done or not secrets.compare_digest(job.id.encode(), name.encode()):
                return None
            return job if job.path.exists() else None

    def estimate(self, window: object, engine: Engine | None, document: Document, wanted: Wanted) -> None:
        """Tell a window what an export will be; a newer call makes it give up."""
        self._number += 1
        if engine is None:
            waiting = {"kind": "estimate", "format": wanted.format, "text": "the maps are being read"}
            self._say(window, waiting)
            return
        given = (self._number, window, engine, document, wanted)
        threading.Thread(target=self._estimate, args=given, name="studio estimate", daemon=True).start()

    def close(self) -> None:
        """End what is under way, and delete the file of the last export."""
        self._number += 1
        with self._lock:
            if self._job is not None:
                self._job.is_ended = True
            thread = self._thread
        if thread is not None:
            thread.join(timeout=5)
        if self._job is not None:
            self._job.forget()

    def _run(self, job: Job, document: Document, wanted: Wanted) -> None:
        _stand_back()
        last = ("", 0.0)

        def watch(stage: str, share: float) -> None:
            nonlocal last
            if job.is_ended:
                raise _EndedError
            now = time.monotonic()
            if stage != last[0] or now - last[1] > _BETWEEN_S:
                last = stage, now
                self._say(job.window, job.message("running", stage=stage, share=round(share, 3)))

        text = "the export failed; the terminal of nmap studio says why"
        said = job.message("failed", text=text)
        try:
            with one_by_one():
                job.path.parent.mkdir()
                made = export(document, job.path, wanted, watch)
            watch("writing", 1.0)
            size = job.path.stat().st_size
            said = job.message("done", name=job.name, bytes=size, notes=made.notes, warnings=made.warnings)
        except _EndedError:
            said = job.message("cancelled")
        except NmaptoolError as error:
            said = job.message("failed", text=str(error))
        except MemoryError:
            said = job.message("failed", text="out of memory; use a smaller map")
        finally:
            if said["state"] != "done":
                job.forget()
            job.is_done = True
            self._say(job.window, said)

    def _estimate(self, number: int, window: object, engine: Engine, document: Document, wanted: Wanted) -> None:
        _stand_back()

        def watch(_stage: str, _share: float) -> None:
            if self._number != number:
                raise _EndedError

        with self._estimating:
            try:
                watch("", 0.0)
                with one_by_one():
                    said = estimate(engine, document, wanted, watch)
            except _EndedError:
                return
            except NmaptoolError as error:
                said = {"kind": "estimate", "format": wanted.format, "text": str(error)}
        if self._number == number:
            self._say(window, said)


def _stand_back() -> None:
    """Let other threads have the processor first, where the system has priorities of threads."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)

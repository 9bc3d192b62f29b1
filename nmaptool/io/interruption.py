"""Files and folders that exist only during a run; they are removed even if the process ends in the middle of a call."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path

from nmaptool.core.errors import OutputError, reason_of


class Unfinished:
    """The unfinished files and folders of a process.

    Attributes
    ----------
    is_complete : bool
        Whether all output of the run is in its final place.
    kept : str
        What an interrupted run leaves, for its message; empty for nothing, as usual.
    """

    def __init__(self) -> None:
        self.is_complete = False
        self.kept = ""
        self._files: set[Path] = set()
        self._folders: list[Path] = []  # a folder comes before the folders in it
        self._temporary: set[Path] = set()
        self._whole = threading.RLock()

    @contextlib.contextmanager
    def all_or_none(self) -> Iterator[None]:
        """Make `sweep` wait until the block ends: for renaming several files, or undoing it."""
        with self._whole:
            yield

    @contextlib.contextmanager
    def swept(self, files: Iterable[Path] = (), folders: Iterable[Path] = ()) -> Iterator[None]:
        """While the block runs, let `sweep` remove these files, and these folders if nothing else is in them."""
        here, around = set(files), list(folders)
        self._files.update(here)
        self._folders.extend(around)
        try:
            yield
        finally:
            self._files.difference_update(here)
            for folder in around:
                self._folders.remove(folder)

    @contextlib.contextmanager
    def temporary_folder(self) -> Iterator[Path]:
        """Make a folder for intermediate files; it is removed when the block ends.

        Raises
        ------
        OutputError
            If the folder cannot be created.
        """
        try:
            # Windows does not remove open files
            made = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        except OSError as error:
            raise OutputError(f"cannot create a temporary folder ({reason_of(error)}); set TMPDIR") from None
        with made as name:
            self._temporary.add(Path(name))
            try:
                yield Path(name)
            finally:
                self._temporary.discard(Path(name))

    @contextlib.contextmanager
    def swept_tree(self, folder: Path) -> Iterator[None]:
        """While the block runs, let `sweep` remove this folder with all that is in it."""
        self._temporary.add(folder)
        try:
            yield
        finally:
            self._temporary.discard(folder)

    def sweep(self) -> None:
        """Remove everything that is unfinished, just before the process ends.

        It keeps the lock, so that no block under `all_or_none` can start any more.
        """
        self._whole.acquire()
        for file in list(self._files):
            with contextlib.suppress(OSError):
                file.unlink(missing_ok=True)
        for folder in reversed(self._folders):
            with contextlib.suppress(OSError):
                folder.rmdir()
        for folder in list(self._temporary):
            shutil.rmtree(folder, ignore_errors=True)


UNFINISHED = Unfinished()

"""What is on disk only while a run lasts, so that one that is ended in the middle of a call leaves nothing."""

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
        Whether what the run was to write is in its place.
    """

    def __init__(self) -> None:
        self.is_complete = False
        self._files: set[Path] = set()
        self._folders: list[Path] = []  # those within others after them
        self._temporary: set[Path] = set()
        self._whole = threading.RLock()

    @contextlib.contextmanager
    def all_or_none(self) -> Iterator[None]:
        """While the block runs, `sweep` waits: for renaming several files, or taking that back."""
        with self._whole:
            yield

    @contextlib.contextmanager
    def swept(self, files: Iterable[Path] = (), folders: Iterable[Path] = ()) -> Iterator[None]:
        """While the block runs, `sweep` removes these; folders only if nothing else is in them."""
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
        """A folder for what is only passed on; it is removed when the block ends.

        Raises
        ------
        OutputError
            If there is no place for temporary files.
        """
        try:
            # Windows does not remove what is open
            made = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        except OSError as error:
            raise OutputError(f"no temporary folder can be made ({reason_of(error)}); set TMPDIR to one") from None
        with made as name:
            self._temporary.add(Path(name))
            try:
                yield Path(name)
            finally:
                self._temporary.discard(Path(name))

    def sweep(self) -> None:
        """Remove everything that is unfinished; for a process that ends here and now.

        What `all_or_none` guards is never begun again after this.
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

"""What is on disk only while a command runs, so that one that is ended in the middle of a call leaves nothing."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path

from nmaptool.core.errors import OutputError, reason_of

_files: set[Path] = set()
_folders: list[Path] = []  # those within others after them
_temporary: set[Path] = set()
# whoever ends the process in the middle of things waits for a change of several files to be whole
_whole = threading.RLock()
_done: list[bool] = []  # whether files were renamed to what they were asked to be


@contextlib.contextmanager
def all_or_none() -> Iterator[None]:
    """While the block runs, `remove_unfinished` waits: for renaming several files, or taking that back."""
    with _whole:
        yield


@contextlib.contextmanager
def unfinished(files: Iterable[Path] = (), folders: Iterable[Path] = ()) -> Iterator[None]:
    """While the block runs, `remove_unfinished` takes these away; folders only if nothing else is in them."""
    here, around = set(files), list(folders)
    _files.update(here)
    _folders.extend(around)
    try:
        yield
    finally:
        _files.difference_update(here)
        for folder in around:
            _folders.remove(folder)


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder for what is only passed on.

    Raises
    ------
    OutputError
        If there is no place for temporary files.
    """
    try:
        made = tempfile.TemporaryDirectory()
    except OSError as error:
        raise OutputError(f"no temporary folder can be made ({reason_of(error)}); set TMPDIR to one") from None
    with made as name:
        _temporary.add(Path(name))
        try:
            yield Path(name)
        finally:
            _temporary.discard(Path(name))


def files_are_done(done: bool) -> None:
    """Note that what a command was to write is in its place, or that a command begins."""
    _done[:] = [done]


def are_files_done() -> bool:
    """Whether what the command was to write is in its place."""
    return _done == [True]


def remove_unfinished() -> None:
    """Take away what `unfinished` and `temporary_folder` still know of; for a process that ends here and now.

    What `all_or_none` guards is never begun again after this.
    """
    _whole.acquire()
    for file in list(_files):
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)
    for folder in reversed(_folders):
        with contextlib.suppress(OSError):
            folder.rmdir()
    for folder in list(_temporary):
        shutil.rmtree(folder, ignore_errors=True)

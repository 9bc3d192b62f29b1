"""What is on disk only while a command runs, so that one that is ended in the middle of a call leaves nothing."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from nmaptool.errors import OutputError, reason_of

_files: set[Path] = set()
_folders: list[Path] = []  # those within others after them
_temporary: set[Path] = set()


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


def remove_unfinished() -> None:
    """Take away what `unfinished` and `temporary_folder` still know of; for a process that ends here and now."""
    for file in list(_files):
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)
    for folder in reversed(_folders):
        with contextlib.suppress(OSError):
            folder.rmdir()
    for folder in list(_temporary):
        shutil.rmtree(folder, ignore_errors=True)

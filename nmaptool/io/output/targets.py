"""Destinations of results, files and open streams, and the checks of them before any work."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, TypeAlias, overload

from nmaptool.core.errors import OutputError, UsageError, reason_of


@dataclass(frozen=True, eq=False)
class OutputStream:
    """An open binary stream that receives a result; every writer takes one in place of a file.

    Bytes are written from the current position on, without seeking, once all other output of the run is written. The
    stream is then flushed and stays open.

    Parameters
    ----------
    stream : binary stream
        Open for writing, and blocking.
    ending : str
        Extension that sets the format, such as ``.png``.
    name : str
        Name for messages.

    Raises
    ------
    UsageError
        If the extension does not begin with a dot.

    Examples
    --------
    >>> import io
    >>> str(OutputStream(io.BytesIO(), ".stl", "the response"))
    'the response'
    """

    stream: BinaryIO
    ending: str
    name: str = "stream"

    def __post_init__(self) -> None:
        if not self.ending.startswith("."):
            raise UsageError(f"{self.name}: the extension {self.ending!r} must begin with a dot, such as .png")

    def __str__(self) -> str:
        return self.name

    @property
    def suffix(self) -> str:
        """The extension, like the ``suffix`` of a path."""
        return self.ending


Place: TypeAlias = Path | OutputStream
Destination: TypeAlias = str | Path | OutputStream


@overload
def place_of(destination: Destination) -> Place: ...
@overload
def place_of(destination: None) -> None: ...
def place_of(destination: Destination | None) -> Place | None:
    """Return a destination as a Path, an OutputStream or None."""
    return destination if destination is None or isinstance(destination, OutputStream) else Path(destination)


def check_place(place: Place, overwrite: bool) -> None:
    """Refuse a place that cannot be written, before any work is done.

    Raises
    ------
    UsageError
        If it is a text stream.
    OutputError
        If the folder is missing or not writable, the target is a folder, or it exists and ``overwrite`` is False; or
        if a stream is not open for writing.
    """
    if isinstance(place, OutputStream):
        _check_stream(place)
        return
    folder = place.parent
    try:
        if place.is_dir():
            raise OutputError(f"{place}: is a folder; give a file name")
        _check_folder(place, folder)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(f"{place}: the folder {folder} cannot be written to")
        place.lstat()
    except FileNotFoundError:
        return
    except OutputError:
        raise
    except OSError as error:
        raise cannot_be_written(place, error) from None
    if not overwrite:
        raise exists_already(place)


def _check_stream(place: OutputStream) -> None:
    if isinstance(place.stream, io.TextIOBase):
        raise UsageError(f"{place}: is a text stream; give a binary stream")
    if place.stream.closed or not place.stream.writable():
        raise OutputError(f"{place}: is not open for writing")


def _check_folder(place: Path, folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{place}: {folder} is a file, not a folder; give another path")
    if not folder.is_dir():
        raise OutputError(f"{place}: the folder {folder} does not exist; create it first")


def check_places(places: Iterable[Place], overwrite: bool, folders: Sequence[Path] = ()) -> None:
    """Apply `check_place` to each and refuse duplicates; places in ``folders`` that do not exist yet are accepted.

    Raises
    ------
    UsageError
        If two are the same file or stream.
    OutputError
        As `check_place`.
    """
    seen: set[object] = set()
    for place in places:
        what = place.stream if isinstance(place, OutputStream) else place.resolve()
        if what in seen:
            raise UsageError(f"{place}: is named twice as an output")
        seen.add(what)
        if isinstance(place, OutputStream) or place.parent not in folders or place.parent.exists():
            check_place(place, overwrite)


def check_folders(folders: Sequence[Path], needed: str) -> None:
    """Refuse folders that cannot be created.

    Parameters
    ----------
    folders : sequence of Path
        The outermost first.
    needed : str
        For messages: what needs them, and the remedy.

    Raises
    ------
    OutputError
    """
    for folder in folders:
        try:
            if folder.exists() and not folder.is_dir():
                raise OutputError(f"{folder}: is a file; {needed}")
        except OutputError:
            raise
        except OSError as error:  # the name is too long, or a folder is not accessible
            raise cannot_be_written(folder, error) from None
    if folders:
        _check_folder(folders[0], folders[0].parent)


def cannot_be_written(place: Place, error: OSError) -> OutputError:
    """The error for a place that the operating system refuses, with its reason."""
    return OutputError(f"{place}: cannot be written ({reason_of(error)})")


def exists_already(place: Path) -> OutputError:
    """The error for a file that must not be replaced."""
    return OutputError(f"{place}: already exists; give another name, or `overwrite`")

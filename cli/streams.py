"""Standard input as a file, standard output for bytes, and their names in messages."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from nmaptool.core.errors import InputError, NmaptoolError, OutputError, UsageError, reason_of
from nmaptool.io.interruption import UNFINISHED

# the file name that replaces - before parsing
STREAM = "standard input"
STDOUT = "standard output"

# file names by role: one, several, or none
Inputs = Mapping[str, "str | tuple[str, ...] | None"]


def refuse_stream(text: str, *names: object) -> None:
    """Refuse - if only a file will do.

    Raises
    ------
    UsageError
    """
    if any(str(name) == STREAM for name in names):
        raise UsageError(f"-: {text}")


def names_in(inputs: Inputs) -> list[str]:
    """Every file name, in order."""
    found: list[str] = []
    for names in inputs.values():
        found += [names] if isinstance(names, str) else names or ()
    return found


@contextlib.contextmanager
def standard_output() -> Iterator[BinaryIO]:
    """Standard output for bytes.

    Raises
    ------
    OutputError
        If it is closed or full.
    """
    if sys.stdout is None:
        raise OutputError(f"{STDOUT}: is closed; give a file name instead of -")
    try:
        sys.stdout.flush()
        yield sys.stdout.buffer
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        close_standard_output()
        raise OutputError(f"{STDOUT}: cannot be written ({reason_of(error)})") from None


class StandardOutput(io.RawIOBase):
    """Standard output as a stream for results, opened at the first write."""

    def writable(self) -> bool:
        """Whether bytes may be written."""
        return True

    def write(self, data: Any) -> int:
        """Write all of the bytes.

        Raises
        ------
        OutputError
            As `standard_output`.
        """
        with standard_output() as stream:
            stream.write(data)
        return len(data)


def close_standard_output() -> None:
    """Redirect standard output to nowhere, so that the interpreter does not report unwritten data at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextlib.contextmanager
def readable(inputs: Inputs) -> Iterator[dict[str, Any]]:
    """The inputs, with `STREAM` replaced by a temporary file that holds standard input.

    Raises
    ------
    InputError
        If standard input is named twice or empty.
    OutputError
        If there is no space to store it.
    """
    count = names_in(inputs).count(STREAM)
    if count > 1:
        raise InputError(f"{STREAM}: can be read only once")
    if not count:
        yield dict(inputs)
        return
    with UNFINISHED.temporary_folder() as folder:
        spooled = str(_spooled(folder))

        def place(name: str) -> str:
            return spooled if name == STREAM else name

        try:
            yield {
                role: place(names) if isinstance(names, str) else names and tuple(place(name) for name in names)
                for role, names in inputs.items()
            }
        except NmaptoolError as error:  # the user does not know the temporary file
            error.args = (str(error).replace(spooled, STREAM), *error.args[1:])
            raise


def _spooled(folder: Path) -> Path:
    """A file in the folder that holds standard input."""
    data = sys.stdin.buffer.read() if sys.stdin is not None else b""
    if not data:
        raise InputError(f"{STREAM}: is empty")
    try:
        (folder / STREAM).write_bytes(data)
    except OSError as error:
        raise OutputError(
            f"{STREAM}: cannot be stored in {folder} ({reason_of(error)}); set TMPDIR to another folder"
        ) from None
    return folder / STREAM


def display_name(name: str) -> str:
    """The name of an input in messages: standard input if it came from there."""
    path = Path(name)
    file, mark, layer = path.name.partition(":")
    return f"{STREAM}{mark}{layer}" if file == STREAM and path.parent.parent == Path(tempfile.gettempdir()) else name


def refuse_inputs(targets: Iterable[Path], names: Iterable[str]) -> None:
    """Refuse to overwrite an input.

    Raises
    ------
    UsageError
    """
    known = list(names)
    for path in targets:
        if path.exists() and any(_is_same(path, name) for name in known):
            raise UsageError(f"{path}: is also an input; give another name for the output")


def _is_same(path: Path, name: str) -> bool:
    """Whether an input, such as ``maps.exr:detail``, is this file."""
    from nmaptool.io.pictures.normal_maps import split_layer

    try:
        return path.samefile(split_layer(name)[0])
    except (OSError, ValueError):  # no such input: the error follows when it is read
        return False

"""Write files and streams together: first to temporary files, then all of them at once to their places."""

from __future__ import annotations

import contextlib
import secrets
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeAlias

from nmaptool.core.errors import OutputError, reason_of
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.output.renaming import renamed
from nmaptool.io.output.targets import OutputStream, Place, cannot_be_written

Job: TypeAlias = tuple[Place, Callable[[Path], object]]
_PIECE_BYTES = 1 << 20


def write_together(jobs: Sequence[Job], overwrite: bool, folders: Sequence[Path] = (), *, final: bool = True) -> None:
    """Write the output of all jobs, or leave every file as it was.

    Parameters
    ----------
    jobs : sequence of (Path or OutputStream, callable)
        The callable writes to a path with the extension of the place.
    overwrite : bool
        Whether to replace files that exist.
    folders : sequence of Path
        Folders to create if missing, the outermost first.
    final : bool
        Whether this completes the run; False for intermediate states.

    Raises
    ------
    OutputError
        If a place cannot be written, or exists and ``overwrite`` is False.
    """
    places = [place for place, _ in jobs]
    with _made(folders), _beside(places) as files:
        for (place, write), file in zip(jobs, files, strict=True):
            with _errors_about(place, file):
                write(file)
        _publish(files, places, overwrite, final)


@contextlib.contextmanager
def _made(folders: Sequence[Path]) -> Iterator[None]:
    """Create the folders; if the block fails, remove the new ones again."""
    new: list[Path] = []
    try:
        for folder in folders:
            if not folder.is_dir():
                try:
                    folder.mkdir()
                except OSError as error:
                    raise OutputError(f"{folder}: cannot be created ({reason_of(error)})") from None
                new.append(folder)
        with UNFINISHED.swept(folders=new):
            yield
    except BaseException:
        for folder in reversed(new):
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise


@contextlib.contextmanager
def _beside(places: Sequence[Place]) -> Iterator[list[Path]]:
    """Temporary files to write: in the folders of the target files, and in a temporary folder for streams."""
    mark = secrets.token_hex(4)
    with contextlib.ExitStack() as stack:
        streamed = any(isinstance(place, OutputStream) for place in places)
        folder = stack.enter_context(UNFINISHED.temporary_folder()) if streamed else Path()
        # short names, because the target's name may have the maximum length
        files = [
            (folder if isinstance(place, OutputStream) else place.parent) / f".{mark}-{number}{place.suffix}"
            for number, place in enumerate(places)
        ]
        stack.enter_context(UNFINISHED.swept(files))
        try:
            yield files
        finally:
            for file in files:
                with contextlib.suppress(OSError):  # another program may have it open, which Windows does not allow
                    file.unlink(missing_ok=True)


@contextlib.contextmanager
def _errors_about(place: Place, file: Path) -> Iterator[None]:
    """Make errors of writing name the place instead of the temporary file."""
    try:
        yield
    except OutputError as error:
        raise OutputError(str(error).replace(str(file), str(place))) from None
    except OSError as error:
        raise cannot_be_written(place, error) from None


def _publish(files: Sequence[Path], places: Sequence[Place], overwrite: bool, final: bool) -> None:
    """Rename the files and send the streams their bytes: the streams last, because sent bytes cannot be taken back."""
    pairs = list(zip(files, places, strict=True))
    moves = [(file, place) for file, place in pairs if isinstance(place, Path)]
    with UNFINISHED.all_or_none():
        with renamed([file for file, _ in moves], [place for _, place in moves], overwrite):
            for file, place in pairs:
                if isinstance(place, OutputStream):
                    _send(file, place)
        UNFINISHED.is_complete = final


def _send(file: Path, place: OutputStream) -> None:
    try:
        with file.open("rb") as made:
            while piece := made.read(_PIECE_BYTES):
                while piece:  # an unbuffered stream may accept only a part
                    taken = place.stream.write(piece)
                    piece = piece[len(piece) if taken is None else taken :]
        place.stream.flush()
    except (BrokenPipeError, OutputError):
        raise
    except OSError as error:
        raise cannot_be_written(place, error) from None

"""One way out: what a run writes is checked before the work, and appears all together or not at all."""

from __future__ import annotations

import contextlib
import json
import secrets
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from nmaptool.core.errors import OutputError, reason_of
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.output.renaming import renamed
from nmaptool.io.output.targets import (
    Destination,
    OutputStream,
    Place,
    cannot_be_written,
    check_ending,
    check_folders,
    check_places,
    place_of,
)

T = TypeVar("T")
Metadata: TypeAlias = Mapping[str, Any]
_Job: TypeAlias = tuple[Place, Callable[[Path], object]]
_PIECE_BYTES = 1 << 20


@dataclass(frozen=True)
class Target(Generic[T]):
    """One file or stream of a run.

    Parameters
    ----------
    place : Path or OutputStream
    what : str
        What is written there, for messages: "a preview".
    endings : collection of str
        Accepted ones, such as ``.png``; none where any is.
    write : callable
        Writes the value to a new file of that ending, and reads it back where writing may fail unheard.
    """

    place: Place
    what: str
    endings: Collection[str]
    write: Callable[[T, Path], object]


def wanted(
    destination: Destination | None, what: str, endings: Collection[str], write: Callable[[T, Path], object]
) -> tuple[Target[T], ...]:
    """A target, or none where no destination is given."""
    return () if destination is None else (Target(place_of(destination), what, endings, write),)


def _value_alone(value: T, metadata: Metadata) -> T:
    return value


@dataclass(frozen=True)
class Outputs(Generic[T]):
    """What one run writes: a plan that can be checked before there is anything to write.

    Parameters
    ----------
    targets : sequence of Target
    report : Path or OutputStream, optional
        Where the metadata go as JSON.
    overwrite : bool
        Replace files that exist.
    folders : sequence of Path
        Folders to make if missing, the outermost first.
    folder_needed : str
        What to say where one of them is a file.
    report_endings : collection of str
        Accepted endings of the report; none where any is.
    rules : sequence of callable
        Checks beyond those of endings and places, made before them.
    prepare : callable
        Makes what the targets write from the value and the metadata, once a run. Default: the value.
    """

    targets: Sequence[Target[Any]] = ()
    report: Place | None = None
    overwrite: bool = False
    folders: Sequence[Path] = ()
    folder_needed: str = "a folder of that name is needed; give another"
    report_endings: Collection[str] = (".json",)
    rules: Sequence[Callable[[], object]] = ()
    prepare: Callable[[T, Metadata], Any] = _value_alone

    @property
    def places(self) -> list[Place]:
        """All files and streams, in the order they are named; the report last."""
        return [*(target.place for target in self.targets), *([] if self.report is None else [self.report])]

    @property
    def paths(self) -> list[Path]:
        """All files."""
        return [place for place in self.places if isinstance(place, Path)]

    @property
    def names(self) -> list[str]:
        """All files and streams as messages call them."""
        return [str(place) for place in self.places]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        """
        for rule in self.rules:
            rule()
        for target in self.targets:
            if target.endings:
                check_ending(target.place, target.endings, target.what)
        if self.report is not None and self.report_endings:
            check_ending(self.report, self.report_endings, "a report")
        check_folders(self.folders, self.folder_needed)
        check_places(self.places, self.overwrite, self.folders)

    def write(self, value: T, metadata: Metadata | None = None, *, final: bool = True) -> None:
        """Write everything, or leave every file as it was.

        Parameters
        ----------
        value
            The result of the run.
        metadata : mapping, optional
            What to put in the report.
        final : bool
            Whether the run is complete with this; False for what is only kept on the way.

        Raises
        ------
        UsageError, OutputError
            As `check`, or if writing fails.
        """
        self.check()
        known = metadata or {}
        prepared = self.prepare(value, known)
        jobs: list[_Job] = [(target.place, partial(target.write, prepared)) for target in self.targets]
        if self.report is not None:
            jobs.append((self.report, lambda path: path.write_text(json.dumps(known, indent=2) + "\n")))
        with contextlib.ExitStack() as stack:
            stack.enter_context(_made(self.folders))
            files = stack.enter_context(_beside(self.places))
            for (place, write), file in zip(jobs, files, strict=True):
                with _errors_about(place, file):
                    write(file)
            _publish(files, self.places, self.overwrite, final)


@contextlib.contextmanager
def _made(folders: Sequence[Path]) -> Iterator[None]:
    """The folders; those that were not there before are removed again where the block fails."""
    new: list[Path] = []
    try:
        for folder in folders:
            if not folder.is_dir():
                try:
                    folder.mkdir()
                except OSError as error:
                    raise OutputError(f"{folder}: cannot be made ({reason_of(error)})") from None
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
    """Files to write first: beside the files that are meant, and in a temporary folder for streams."""
    mark = secrets.token_hex(4)
    with contextlib.ExitStack() as stack:
        streamed = any(isinstance(place, OutputStream) for place in places)
        folder = stack.enter_context(UNFINISHED.temporary_folder()) if streamed else Path()
        # short names: the target's own may be as long as a name can be
        files = [
            (folder if isinstance(place, OutputStream) else place.parent) / f".{mark}-{number}{place.suffix}"
            for number, place in enumerate(places)
        ]
        stack.enter_context(UNFINISHED.swept(files))
        try:
            yield files
        finally:
            for file in files:
                file.unlink(missing_ok=True)


@contextlib.contextmanager
def _errors_about(place: Place, file: Path) -> Iterator[None]:
    """Errors of writing speak of the place that is meant, not of the file that is written first."""
    try:
        yield
    except OutputError as error:
        raise OutputError(str(error).replace(str(file), str(place))) from None
    except OSError as error:
        raise cannot_be_written(place, error) from None


def _publish(files: Sequence[Path], places: Sequence[Place], overwrite: bool, final: bool) -> None:
    """Rename the files and send the streams their bytes: the streams last, since a byte sent cannot be taken back."""
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
                while piece:  # an unbuffered stream may take a part only
                    taken = place.stream.write(piece)
                    piece = piece[len(piece) if taken is None else taken :]
        place.stream.flush()
    except (BrokenPipeError, OutputError):
        raise
    except OSError as error:
        raise cannot_be_written(place, error) from None

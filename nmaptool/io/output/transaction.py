"""One way out: what a run writes is checked before the work, and appears all together or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from nmaptool.io.output.targets import Destination, Place, check_folders, check_places, place_of
from nmaptool.io.output.writing import Job, write_together
from nmaptool.options.formats import check_ending

T = TypeVar("T")
Metadata: TypeAlias = Mapping[str, Any]


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
        jobs: list[Job] = [(target.place, partial(target.write, prepared)) for target in self.targets]
        if self.report is not None:
            text = json.dumps(known, indent=2) + "\n"
            jobs.append((self.report, lambda path: path.write_text(text, encoding="utf-8", newline="\n")))
        write_together(jobs, self.overwrite, self.folders, final=final)

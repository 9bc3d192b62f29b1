"""The single path for output: a run's files are checked before the work, and appear all together or not at all."""

from __future__ import annotations

import json
import time
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
        Accepted extensions, such as ``.png``; empty if all are.
    write : callable
        Writes the value to a new file with that extension, and reads it back if writing can fail without an error.
    """

    place: Place
    what: str
    endings: Collection[str]
    write: Callable[[T, Path], object]


def wanted(
    destination: Destination | None, what: str, endings: Collection[str], write: Callable[[T, Path], object]
) -> tuple[Target[T], ...]:
    """Return a tuple with the target, or an empty one if no destination is given."""
    return () if destination is None else (Target(place_of(destination), what, endings, write),)


def _value_alone(value: T, metadata: Metadata) -> T:
    return value


@dataclass(frozen=True)
class Outputs(Generic[T]):
    """The output of one run: a plan that can be checked before there is anything to write.

    Parameters
    ----------
    targets : sequence of Target
    report : Path or OutputStream, optional
        Where to write the metadata as JSON.
    overwrite : bool
        Replace files that exist.
    folders : sequence of Path
        Folders to create if missing, the outermost first.
    folder_needed : str
        For the message if one of them is a file: what needs the folder, and the remedy.
    report_endings : collection of str
        Accepted extensions of the report; empty if all are.
    rules : sequence of callable
        Further checks, made before those of extensions and places.
    prepare : callable
        Called once per run with the value and the metadata; returns what the targets write. Default: the value.
    """

    targets: Sequence[Target[Any]] = ()
    report: Place | None = None
    overwrite: bool = False
    folders: Sequence[Path] = ()
    folder_needed: str = "a folder is needed; give another name"
    report_endings: Collection[str] = (".json",)
    rules: Sequence[Callable[[], object]] = ()
    prepare: Callable[[T, Metadata], Any] = _value_alone

    @property
    def places(self) -> list[Place]:
        """All files and streams, in order; the report last."""
        return [*(target.place for target in self.targets), *([] if self.report is None else [self.report])]

    @property
    def paths(self) -> list[Path]:
        """All files."""
        return [place for place in self.places if isinstance(place, Path)]

    @property
    def names(self) -> list[str]:
        """The names of all files and streams for messages."""
        return [str(place) for place in self.places]

    def check(self) -> None:
        """Refuse output that could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an extension is not supported or a file is named twice.
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

    def write(self, value: T, metadata: Metadata | None = None, *, final: bool = True) -> dict[str, Any]:
        """Write everything, or leave every file as it was.

        Parameters
        ----------
        value
            The result of the run.
        metadata : mapping, optional
            What to put in the report; its "seconds", if it has them, get those of writing the other files.
        final : bool
            Whether this completes the run; False for intermediate states.

        Returns
        -------
        dict
            The report: the metadata with the seconds of writing.

        Raises
        ------
        UsageError, OutputError
            As `check`, or if writing fails.
        """
        self.check()
        known = dict(metadata or {})
        started = time.perf_counter()
        prepared = self.prepare(value, known)
        jobs: list[Job] = [(target.place, partial(target.write, prepared)) for target in self.targets]
        reported = known

        def write_report(path: Path) -> None:
            nonlocal reported
            if jobs[:-1]:
                reported = _timed(known, time.perf_counter() - started)
            path.write_text(json.dumps(reported, indent=2) + "\n", encoding="utf-8", newline="\n")

        if self.report is not None:
            jobs.append((self.report, write_report))
        write_together(jobs, self.overwrite, self.folders, final=final)
        if self.report is None and jobs:
            reported = _timed(known, time.perf_counter() - started)
        return reported


def _timed(metadata: dict[str, Any], seconds: float) -> dict[str, Any]:
    """The metadata with the seconds of writing, if it has those of other stages."""
    stages = metadata.get("seconds")
    return metadata | {"seconds": {**stages, "writing": round(seconds, 4)}} if isinstance(stages, Mapping) else metadata

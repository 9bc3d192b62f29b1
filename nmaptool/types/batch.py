"""The jobs of a batch, the items that they stand for, and the results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from nmaptool.types.shown import OneLine

BatchStatus = Literal["done", "skipped", "failed", "refused"]


@dataclass(frozen=True)
class BatchJob:
    """One command for a set of inputs: a row of a table of jobs, or a command line.

    Parameters
    ----------
    command : str
        Such as "relief" or "compose convert".
    inputs : tuple of str
        File names and patterns, such as ``maps/*.png``.
    options : mapping
        Options by the name of their flag, without dashes, such as ``{"height": "4mm", "output": "out/{stem}.stl"}``; a
        list for a flag that is repeated, True for a switch.
    words : tuple of str
        Further flags as on the command line.
    folder : Path
        Folder that file names are relative to.
    place : str
        Where the job is written, for messages: "jobs.toml, job 2".
    """

    command: str
    inputs: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    folder: Path = Path()
    place: str = ""


@dataclass(frozen=True)
class BatchItem:
    """One run of a command in a batch.

    Parameters
    ----------
    command : str
    arguments : tuple
        The files that its command line names without a flag.
    flags : mapping
        The parsed values of its flags, by the names of their options.
    inputs : tuple of str
        The inputs, relative to ``folder``.
    files : tuple of str
        Every file that it reads, those that its inputs name included.
    outputs : tuple of str
        The files, or the folder, that its flags name to be written.
    recipe : str
        Hash of the command, the values of its options, the version and the identity of the inputs.
    folder : str
        The folder that it runs in.
    place : str
        Where its job is written, for messages.
    """

    command: str
    arguments: tuple[Any, ...]
    flags: Mapping[str, Any]
    inputs: tuple[str, ...]
    files: tuple[str, ...]
    outputs: tuple[str, ...]
    recipe: str
    folder: str
    place: str = ""


@dataclass(frozen=True, repr=False)
class BatchResult(OneLine):
    """How one item of a batch ended.

    Attributes
    ----------
    inputs, outputs : tuple of str
        The files that it read, and those that it wrote (or should have written).
    exit_code : int
        The exit code of the command.
    status : str
        "done"; "skipped": done by an earlier run and unchanged since; "refused": its options, its size or its existing
        outputs were not accepted; "failed".
    message : str
        The one line of the error; empty if there is none.
    warnings : tuple of str
    seconds : float
    recipe : str
        Hash of the command, the values of its options, the version and the identity of the inputs.
    notes : tuple of str
        The other lines that the command wrote to standard error.
    report : Any
        What the command printed to standard output: a parsed JSON value or text; None if nothing.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    exit_code: int
    status: BatchStatus
    message: str = ""
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0
    recipe: str = ""
    notes: tuple[str, ...] = ()
    report: Any = None

    def _line(self) -> str:
        ended = f", {self.message}" if self.message else f" in {self.seconds:.2f} s" if self.status == "done" else ""
        return f"{' '.join(self.inputs)}: {self.status}{ended}"

    def to_dict(self) -> dict[str, Any]:
        """Return the plain values of its JSON line: without notes, and with a report only if there is one."""
        values = asdict(self)
        del values["notes"]
        if self.report is None:
            del values["report"]
        return values

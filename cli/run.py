"""One run of a command: what it was given, what it says, and how its results go out."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from nmaptool._version import __version__
from nmaptool.core.progress import Progress
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Switch
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.streams import STDOUT, Inputs, names_in, readable, refuse_inputs, standard_output

if TYPE_CHECKING:
    from nmaptool.io.output.transaction import Outputs
    from nmaptool_cli.per_input import PerInput

_Given = TypeVar("_Given", bound=Options)
_Result = TypeVar("_Result")


@dataclass(frozen=True)
class RunOptions(Options, group="Run"):
    """How a command speaks.

    Parameters
    ----------
    quiet:
        Say nothing but errors.
    verbose:
        Say more: the residual history and the time of each stage.
    json:
        Print the full report as JSON on standard output.
    """

    quiet: bool = option(False, Switch(), short="-q")
    verbose: bool = option(False, Switch(), short="-v")
    json: bool = option(False, Switch())


class Run:
    """One run of a command.

    Messages are kept until the results are written: a run that fails says one line only.

    Parameters
    ----------
    given : mapping
        The options, by their class.
    words : mapping
        What flags that are given once for each input hold.
    per_input : PerInput or None
        What these flags are.
    """

    def __init__(
        self, given: Mapping[type[Options], Options], words: Mapping[str, Any], per_input: PerInput | None
    ) -> None:
        self._given = given
        self._words = words
        self._per_input = per_input
        self._messages: list[str] = []
        self._targets: list[Path] = []
        self.inputs: Inputs = {}
        self.options = self[RunOptions]

    def __getitem__(self, options: type[_Given]) -> _Given:
        """The options of a class."""
        return cast("_Given", self._given[options])

    def per_input(self, count: int) -> list[Any]:
        """The options of each of ``count`` inputs."""
        assert self._per_input is not None  # the command has such flags
        return self._per_input.spread(self._words, count)

    def begin(self, outputs: Outputs[Any] | None = None, **inputs: str | tuple[str, ...] | None) -> None:
        """Check what can be checked before the work: that outputs can be written, and none of them is an input.

        Raises
        ------
        UsageError, OutputError
        """
        self.inputs = inputs
        if outputs is not None:
            outputs.check()
            self._targets = outputs.paths
        self.refuse_inputs(*names_in(inputs))

    def refuse_inputs(self, *names: str) -> None:
        """Refuse to write over what is read.

        Raises
        ------
        UsageError
        """
        refuse_inputs(self._targets, names)

    @contextlib.contextmanager
    def work(self) -> Iterator[tuple[dict[str, Any], Progress | None]]:
        """The inputs as files that can be read, by role, and who is told of the progress."""
        with readable(self.inputs) as files, self.progress() as progress:
            yield files, progress

    def header(self, **more: Any) -> dict[str, Any]:
        """What every report begins with: the version and the files that were read."""
        files = {role: names for role, names in self.inputs.items() if names is not None}
        return {"version": __version__, "files": files, **more}

    def finish(
        self,
        outputs: Outputs[_Result],
        value: _Result,
        metadata: Mapping[str, Any],
        *,
        written: Iterable[str] | None = None,
        done: Callable[[], object] | None = None,
    ) -> None:
        """Write the results, say everything, and print the report where it goes to standard output.

        Parameters
        ----------
        outputs : Outputs
        value
            The result.
        metadata : mapping
            The report.
        written : iterable of str, optional
            What to say was written. Default: the outputs' names.
        done : callable, optional
            Called once the results are written.
        """
        report = {**metadata, "outputs": outputs.names}
        outputs.write(value, report)
        if done is not None:
            done()
        for name in outputs.names if written is None else written:
            self.say(f"  wrote {'the map to standard output' if name == STDOUT else name}")
        self.speak()
        if self.options.json or any(getattr(given, "prints_report", False) for given in self._given.values()):
            self.data(report)

    def say(self, *lines: str) -> None:
        """Messages, unless quiet."""
        if not self.options.quiet:
            self._messages += lines

    def detail(self, *lines: str) -> None:
        """Messages for --verbose."""
        if self.options.verbose:
            self.say(*lines)

    def seconds(self, seconds: Mapping[str, float]) -> None:
        """The time of each stage, for --verbose."""
        self.detail(f"  seconds {', '.join(f'{stage} {value:.2f}' for stage, value in seconds.items())}")

    def warn(self, *warnings: str) -> None:
        """Warnings, unless quiet."""
        self.say(*(f"nmap: warning: {text}" for text in warnings))

    def speak(self) -> None:
        """Print the messages so far on stderr."""
        for text in self._messages:
            print(in_flags(text), file=sys.stderr)
        self._messages.clear()

    def data(self, value: Any) -> None:
        """A JSON value on standard output."""
        with standard_output() as stream:
            stream.write(json.dumps(value, indent=2).encode() + b"\n")

    @contextlib.contextmanager
    def progress(self) -> Iterator[Progress | None]:
        """A progress bar on stderr where that is a terminal and the work takes longer than a second, else nothing."""
        if self.options.quiet or not sys.stderr.isatty():
            yield None
            return
        from nmaptool_cli.late_bar import LateBar

        bar = LateBar()
        try:
            yield bar.report
        finally:
            bar.stop()

"""One run of a command: its options, its messages and its results."""

from __future__ import annotations

import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from nmaptool._version import __version__
from nmaptool.core.extension import kernels_in_use
from nmaptool.core.progress import Progress
from nmaptool.options import FilterOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Switch
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.missing_loops import loop_warnings
from nmaptool_cli.streams import STDOUT, Inputs, names_in, readable, refuse_inputs, standard_output

if TYPE_CHECKING:
    from nmaptool.io.output.transaction import Outputs
    from nmaptool_cli.per_input import PerInput

# takes the names of all files that a run has written, for a batch
WRITTEN: ContextVar[list[str] | None] = ContextVar("written files", default=None)

_Given = TypeVar("_Given", bound=Options)
_Result = TypeVar("_Result")


@dataclass(frozen=True)
class RunOptions(Options, group="Run"):
    """What a command prints.

    Parameters
    ----------
    quiet:
        Print nothing but errors.
    verbose:
        Also print the solver's residuals and the time of each stage.
    json:
        Print the full report as JSON to standard output.
    """

    quiet: bool = option(False, Switch(), short="-q")
    verbose: bool = option(False, Switch(), short="-v")
    json: bool = option(False, Switch())


class Run:
    """One run of a command.

    Messages are held back until the results are written, so that a run that fails prints only its error.

    Parameters
    ----------
    given : mapping
        The options, by their class, but not those whose flags only complete a preset or recipe.
    named : mapping
        The options that are on the command line, by class.
    words : mapping
        Values of the flags that may be given once for each input.
    per_input : PerInput or None
        The definition of these flags.
    """

    def __init__(
        self,
        given: Mapping[type[Options], Options],
        named: Mapping[type[Options], Mapping[str, Any]],
        words: Mapping[str, Any],
        per_input: PerInput | None,
    ) -> None:
        self._given = given
        self._named = named
        self._words = words
        self._per_input = per_input
        self._messages: list[str] = []
        self._targets: list[Path] = []
        self._reading_s = 0.0
        self.inputs: Inputs = {}
        self.options = self[RunOptions]

    def __getitem__(self, options: type[_Given]) -> _Given:
        """The options of a class."""
        return cast("_Given", self._given[options])

    def named(self, options: type[Options]) -> dict[str, Any]:
        """The options of a class that are on the command line."""
        return dict(self._named[options])

    def per_input(self, count: int) -> list[Any]:
        """The options of each of ``count`` inputs."""
        assert self._per_input is not None  # the command has such flags
        return self._per_input.spread(self._words, count)

    def begin(self, outputs: Outputs[Any] | None = None, **inputs: str | tuple[str, ...] | None) -> None:
        """Check before the work that every output can be written and that none of them is an input.

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
        """Refuse to overwrite an input.

        Raises
        ------
        UsageError
        """
        refuse_inputs(self._targets, names)

    @contextlib.contextmanager
    def work(self) -> Iterator[tuple[dict[str, Any], Progress | None]]:
        """The inputs as readable files, by role, and the function that reports progress."""
        with readable(self.inputs) as files, self.progress() as progress:
            yield files, progress

    @contextlib.contextmanager
    def reading(self) -> Iterator[None]:
        """Measure the time of reading an input, for the report."""
        started = time.perf_counter()
        try:
            yield
        finally:
            self._reading_s += time.perf_counter() - started

    def header(self, **more: Any) -> dict[str, Any]:
        """The first entries of every report: the version and the files that were read."""
        files = {role: names for role, names in self.inputs.items() if names is not None}
        return {"version": __version__, "kernels": kernels_in_use(), "files": files, **more}

    def finish(
        self,
        outputs: Outputs[_Result],
        value: _Result,
        metadata: Mapping[str, Any],
        *,
        written: Iterable[str] | None = None,
        done: Callable[[], object] | None = None,
        watched: Callable[[_Result, Progress], _Result] | None = None,
    ) -> None:
        """Write the results, print the messages, and print the report if it goes to standard output.

        Parameters
        ----------
        outputs : Outputs
        value
            The result.
        metadata : mapping
            The report.
        written : iterable of str, optional
            Names of the written files for the messages. Default: the outputs' names.
        done : callable, optional
            Called once the results are written.
        watched : callable, optional
            Gives the value the function that reports progress. Default: writing reports none.
        """
        report = {**metadata, "outputs": [*metadata.get("outputs", ()), *outputs.names]}
        if self._reading_s:
            report["seconds"] = {"reading": round(self._reading_s, 4), **report.get("seconds", {})}
        with self.progress() as progress:
            if watched is not None and progress is not None:
                value = watched(value, progress)
            report = outputs.write(value, report)
        watched_names = WRITTEN.get()
        if watched_names is not None:
            watched_names += map(str, outputs.paths)
        if done is not None:
            done()
        self.warn(*loop_warnings(self._named, self._given.get(FilterOptions)))
        for name in outputs.names if written is None else written:
            self.say(f"  wrote {'the map to standard output' if name == STDOUT else name}")
        self.speak()
        if self.options.json or any(getattr(given, "prints_report", False) for given in self._given.values()):
            self.data(report)

    def say(self, *lines: str) -> None:
        """Add messages, unless quiet."""
        if not self.options.quiet:
            self._messages += lines

    def detail(self, *lines: str) -> None:
        """Add messages for --verbose."""
        if self.options.verbose:
            self.say(*lines)

    def seconds(self, seconds: Mapping[str, float]) -> None:
        """Add the time of each stage, for --verbose."""
        self.detail(f"  seconds {', '.join(f'{stage} {value:.2f}' for stage, value in seconds.items())}")

    def warn(self, *warnings: str) -> None:
        """Add warnings, unless quiet."""
        self.say(*(f"nmap: warning: {text}" for text in warnings))

    def speak(self) -> None:
        """Print the messages so far to stderr."""
        for text in self._messages:
            print(in_flags(text), file=sys.stderr)
        self._messages.clear()

    def data(self, value: Any) -> None:
        """Print a JSON value to standard output."""
        with standard_output() as stream:
            stream.write(json.dumps(value, indent=2).encode() + b"\n")

    @contextlib.contextmanager
    def progress(self) -> Iterator[Progress | None]:
        """A progress bar, if stderr is a terminal and the work takes longer than a second."""
        if self.options.quiet or not sys.stderr.isatty():
            yield None
            return
        from nmaptool_cli.late_bar import LateBar

        bar = LateBar()
        try:
            yield bar.report
        finally:
            bar.stop()

"""What every command shares: messages on stderr, data on stdout, progress, exit codes, standard input as a file."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from cyclopts import Group, Parameter
from cyclopts.exceptions import CoercionError, CycloptsError, UnusedCliTokensError

from nmaptool.core.errors import InputError, NmaptoolError, OutputError, UsageError, reason_of
from nmaptool.core.progress import Progress
from nmaptool.core.units import Length, length
from nmaptool.io.interruption import UNFINISHED
from nmaptool.options import FilterOptions

EXIT_USAGE = 2
EXIT_LIMIT = 4
EXIT_OUTPUT = 5
EXIT_INTERRUPTED = 130
EXIT_BUG = 70

# what - stands for once the words are parsed
STREAM = "standard input"
STDOUT = "standard output"

# a Length is one word on the command line, such as 12mm
Parameter(n_tokens=1, accepts_keys=False, converter=lambda _, tokens: length(tokens[0].value))(Length)


def size_of(text: str) -> float | Length:
    """A plain number or a `Length`."""
    try:
        return float(text)
    except ValueError:
        return length(text)


# the parser alone would want a float, or a Length as two words
_SIZE = Parameter(n_tokens=1, accepts_keys=False, converter=lambda _, tokens: size_of(tokens[0].value))
FilterOptions.__annotations__["sigma_s"] = Annotated[float | Length, _SIZE]


# groups of flags in the order that --help shows them
_GROUPS = ("Inputs", "Outputs", "Camera", "Filter", "Rebuilding", "Composing", "Relief", "Reading", "Run")
INPUTS, OUTPUTS, CAMERA, FILTER, REBUILDING, COMPOSING, RELIEF, READING, RUN = (
    Group(name, sort_key=place) for place, name in enumerate(_GROUPS, start=1)
)


@dataclass(frozen=True)
class RunOptions:
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

    quiet: Annotated[bool, Parameter(alias="-q")] = False
    verbose: Annotated[bool, Parameter(alias="-v")] = False
    json: bool = False


class Session:
    """One run of a command.

    Parameters
    ----------
    options : RunOptions
    """

    def __init__(self, options: RunOptions) -> None:
        self.options = options

    def say(self, text: str) -> None:
        """A message, unless quiet."""
        if not self.options.quiet:
            print(text, file=sys.stderr)

    def detail(self, text: str) -> None:
        """A message for --verbose."""
        if self.options.verbose and not self.options.quiet:
            print(text, file=sys.stderr)

    def warn(self, text: str) -> None:
        """A warning, unless quiet."""
        self.say(f"nmap: warning: {text}")

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


@contextlib.contextmanager
def standard_output() -> Iterator[BinaryIO]:
    """Standard output for bytes.

    Raises
    ------
    OutputError
        If it is closed, or what it leads to is full.
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
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter complains at exit
        raise OutputError(f"{STDOUT}: cannot be written ({reason_of(error)})") from None


class StandardOutput(io.RawIOBase):
    """Standard output as a stream for results; it may be closed until it is written to."""

    def writable(self) -> bool:
        """It is only written to."""
        return True

    def write(self, data: Any, /) -> int:
        """Write all of the bytes."""
        with standard_output() as stream:
            stream.write(data)
        return len(data)


@contextlib.contextmanager
def input_files(*names: str | None) -> Iterator[list[str | None]]:
    """The names, with `STREAM` replaced by a temporary file that holds standard input.

    Raises
    ------
    InputError
        If standard input is named twice or empty.
    OutputError
        If there is no room to keep it in.
    """
    if names.count(STREAM) > 1:
        raise InputError(f"{STREAM}: can be read once only")
    if STREAM not in names:
        yield list(names)
        return
    with UNFINISHED.temporary_folder() as folder:
        data = sys.stdin.buffer.read() if sys.stdin is not None else b""
        if not data:
            raise InputError(f"{STREAM}: is empty")
        spooled = folder / STREAM
        try:
            spooled.write_bytes(data)
        except OSError as error:
            raise OutputError(f"{STREAM}: cannot be kept in {folder} ({reason_of(error)}); set TMPDIR") from None
        try:
            yield [str(spooled) if name == STREAM else name for name in names]
        except NmaptoolError as error:  # nobody knows the temporary file
            error.args = (str(error).replace(str(spooled), STREAM), *error.args[1:])
            raise


def refuse_inputs(targets: Iterable[Path], inputs: Iterable[str | None]) -> None:
    """Refuse to write over what is read.

    Raises
    ------
    UsageError
    """
    names = [name for name in inputs if name]
    for path in targets:
        if path.exists() and any(_is_same(path, name) for name in names):
            raise UsageError(f"{path}: is also an input; give another name for the output")


def _is_same(path: Path, name: str) -> bool:
    """Whether an input, such as ``maps.exr:detail``, is in that file."""
    from nmaptool.io.pictures.normal_maps import split_layer

    try:
        return path.samefile(split_layer(name)[0])
    except (OSError, ValueError):  # there is no such input: reading it tells
        return False


def display_name(name: str) -> str:
    """What to call an input in messages: standard input where it was read from there."""
    path = Path(name)
    return STREAM if path.name == STREAM and path.parent.parent == Path(tempfile.gettempdir()) else name


def _usage(error: CycloptsError) -> str:
    """A parser's complaint in a designer's words."""
    if isinstance(error, CoercionError) and error.token is not None and error.target_type in (int, float):
        kind = "a whole number" if error.target_type is int else "a number"
        return f"{error.token.keyword} {error.token.value!r}: must be {kind}"
    if isinstance(error, UnusedCliTokensError):
        return f"{' '.join(error.unused_tokens or [])}: is one word too many; see what the command takes with --help"
    return str(error)


def _fail(text: str, code: int) -> int:
    print(f"nmap: error: {' '.join(text.split())}", file=sys.stderr)
    return code


_ending = threading.Lock()


def interrupted() -> int:
    """Say so, once however many threads say it."""
    if not _ending.acquire(False):
        return EXIT_INTERRUPTED
    left = "what was to be written is complete" if UNFINISHED.is_complete else "nothing was written"
    return _fail(f"interrupted; {left}", EXIT_INTERRUPTED)


def run_guarded(command: Callable[[], Any]) -> int:
    """Run a command; every failure is one line on stderr and an exit code, never a traceback."""
    if _ending.locked():  # by a command before, where one process runs several
        _ending.release()
    UNFINISHED.is_complete = False
    try:
        code = command()
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except NmaptoolError as error:
        return _fail(str(error), error.exit_code)
    except CycloptsError as error:
        if isinstance(error.__cause__, NmaptoolError):
            return _fail(str(error.__cause__), error.__cause__.exit_code)
        return _fail(f"{_usage(error)} (see nmap --help)", EXIT_USAGE)
    except MemoryError:
        return _fail("out of memory; use a smaller map", EXIT_LIMIT)
    except KeyboardInterrupt:
        return interrupted()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter complains at exit
        return EXIT_OUTPUT
    except Exception as error:  # the last line of defence: a designer should not meet a traceback
        if os.environ.get("NMAPTOOL_TRACEBACK"):
            raise
        return _fail(
            f"this is a bug in nmaptool ({type(error).__name__}: {error}); run again with NMAPTOOL_TRACEBACK=1 and "
            "report what it prints",
            EXIT_BUG,
        )

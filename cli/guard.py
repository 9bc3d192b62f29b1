"""How a command ends: every failure gives one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import errno
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

from cyclopts.exceptions import CoercionError, CycloptsError, MissingArgumentError, UnusedCliTokensError

from nmaptool.core.errors import NmaptoolError, reason_of
from nmaptool.io.interruption import UNFINISHED
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.streams import STDOUT, close_standard_output

EXIT_USAGE = 2
EXIT_LIMIT = 4
EXIT_OUTPUT = 5
EXIT_BUG = 70
EXIT_INTERRUPTED = 130

# set as soon as Ctrl-C arrives, so that the command ends the same way whatever a library does with the exception
CTRL_C = threading.Event()
_ending = threading.Lock()


def run_guarded(command: Callable[[], Any]) -> int:
    """Run a command and return its exit code."""
    if _ending.locked():  # left locked by an earlier command of the same process
        _ending.release()
    UNFINISHED.is_complete, UNFINISHED.kept = False, ""
    CTRL_C.clear()
    try:
        code = command()
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except KeyboardInterrupt:
        return interrupted()
    except Exception as error:  # noqa: BLE001 - it is reported or raised again
        return interrupted() if CTRL_C.is_set() else _failed(error)


def _failed(error: Exception) -> int:
    """Print what went wrong and return the exit code."""
    match error:
        case NmaptoolError():
            return _fail(str(error), error.exit_code)
        case CycloptsError(__cause__=NmaptoolError() as cause):
            return _fail(str(cause), cause.exit_code)
        case CycloptsError():
            command = " ".join(("nmap", *(error.command_chain or ())))
            return _fail(f"{usage(error)} (see {command} --help)", EXIT_USAGE)
        case MemoryError():
            return _fail("out of memory; use a smaller map", EXIT_LIMIT)
        case BrokenPipeError():
            close_standard_output()
            return EXIT_OUTPUT
        case OSError(errno=errno.ENOSPC):  # files raise their own errors: this is a report, or --help
            close_standard_output()
            return _fail(f"{STDOUT}: cannot be written ({reason_of(error)})", EXIT_OUTPUT)
    if os.environ.get("NMAPTOOL_TRACEBACK"):
        raise error
    return _fail(  # the last line of defence: a designer should not meet a traceback
        f"this is a bug in nmaptool ({type(error).__name__}: {error}); run again with NMAPTOOL_TRACEBACK=1 and "
        "report the output",
        EXIT_BUG,
    )


def interrupted() -> int:
    """Print that the command was interrupted, only once for all threads, and return the exit code."""
    if not _ending.acquire(False):
        return EXIT_INTERRUPTED
    left = UNFINISHED.kept or ("all outputs were written" if UNFINISHED.is_complete else "nothing was written")
    return _fail(f"interrupted; {left}", EXIT_INTERRUPTED)


def usage(error: CycloptsError) -> str:
    """The parser's error in words for a designer."""
    if isinstance(error, CoercionError) and error.token is not None and error.target_type in (int, float):
        kind = "a whole number" if error.target_type is int else "a number"
        return f"{error.token.keyword} {error.token.value!r}: must be {kind}"
    if isinstance(error, UnusedCliTokensError):
        return f"{' '.join(error.unused_tokens or [])}: unexpected argument"
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        return f"{error.keyword}: needs a value" if error.keyword else f"{error.argument.name} is missing"
    return str(error).removesuffix(".")


def _fail(text: str, code: int) -> int:
    print(f"nmap: error: {' '.join(in_flags(text).split())}", file=sys.stderr)
    return code

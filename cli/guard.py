"""How a command ends: every failure is one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from typing import Any

from cyclopts.exceptions import CoercionError, CycloptsError, UnusedCliTokensError

from nmaptool.core.errors import NmaptoolError
from nmaptool.io.interruption import UNFINISHED
from nmaptool_cli.streams import close_standard_output

EXIT_USAGE = 2
EXIT_LIMIT = 4
EXIT_OUTPUT = 5
EXIT_BUG = 70
EXIT_INTERRUPTED = 130

_ending = threading.Lock()


def run_guarded(command: Callable[[], Any]) -> int:
    """Run a command; its exit code."""
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
        close_standard_output()
        return EXIT_OUTPUT
    except Exception as error:  # the last line of defence: a designer should not meet a traceback
        if os.environ.get("NMAPTOOL_TRACEBACK"):
            raise
        return _fail(
            f"this is a bug in nmaptool ({type(error).__name__}: {error}); run again with NMAPTOOL_TRACEBACK=1 and "
            "report what it prints",
            EXIT_BUG,
        )


def interrupted() -> int:
    """Say that the command was interrupted, once however many threads say it."""
    if not _ending.acquire(False):
        return EXIT_INTERRUPTED
    left = "what was to be written is complete" if UNFINISHED.is_complete else "nothing was written"
    return _fail(f"interrupted; {left}", EXIT_INTERRUPTED)


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

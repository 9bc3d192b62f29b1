"""Run one item of a batch in a worker process: the same code as the command, with its messages caught."""

from __future__ import annotations

import contextlib
import gc
import io
import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

from nmaptool.core.parallel import at_most
from nmaptool.io.sets.identity import identity
from nmaptool.solver.kept import SolverKeeper, keeping
from nmaptool.types.batch import BatchItem, BatchResult, BatchStatus
from nmaptool_cli.guard import EXIT_LIMIT, EXIT_OUTPUT, EXIT_USAGE, run_guarded
from nmaptool_cli.run import WRITTEN
from nmaptool_cli.sets.parsed import named_command

ERROR, WARNING = "nmap: error: ", "nmap: warning: "


class ItemRunner:
    """Runs the items of one process, one after the other: standard output belongs to the process.

    Parameters
    ----------
    threads : int or None
        Cores that an item may use; None for all.
    """

    def __init__(self, threads: int | None = None) -> None:
        self.keeper = SolverKeeper()
        self._threads = threads
        self._alone = threading.Lock()

    def run(self, item: BatchItem, begun: Path | None = None) -> BatchResult:
        """Run an item in its folder and return its result; first create the file ``begun``."""
        with self._alone, contextlib.ExitStack() as stack:
            if begun is not None:
                begun.touch()
            started = time.perf_counter()
            stack.enter_context(keeping(self.keeper))
            if self._threads is not None:
                stack.enter_context(at_most(self._threads))
            had_outputs = any(os.path.lexists(os.path.join(item.folder, name)) for name in item.outputs)  # noqa: PTH118
            try:
                stack.enter_context(contextlib.chdir(item.folder))
                for name in item.outputs:
                    Path(name).parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                place = error.filename or item.folder
                return _unstarted(item, f"{place}: is not accessible to the worker ({error.strerror})")
            before = {name: identity(Path(name)) for name in item.outputs}
            written: list[str] = []
            token = WRITTEN.set(written)
            try:
                code, out, err = _called(item)
            finally:
                WRITTEN.reset(token)
            written += [name for name, known in before.items() if _is_new(name, known, written)]
            return _result(item, code, written, out, err, had_outputs, time.perf_counter() - started)


def _is_new(name: str, before: tuple[str, int, int], written: list[str]) -> bool:
    """Whether an output is written that the run has not told, such as a store."""
    path = Path(name)
    told = any(path in (Path(each), *Path(each).parents) for each in written)
    return not told and identity(path) not in (before, (name, -1, -1)) and os.path.lexists(path)


def _called(item: BatchItem) -> tuple[int, str, str]:
    """The exit code of a command, and what it wrote to standard output and standard error."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="backslashreplace", newline="\n")
    err = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        # its words are parsed already: that takes a fifth of the time of a small map
        code = run_guarded(lambda: named_command(item.command)(*item.arguments, **item.flags))
    sys.stdout.flush()
    out.flush()
    gc.collect(1)  # arrays in cycles of errors would add to the memory of the next item
    raw = out.detach()
    assert isinstance(raw, io.BytesIO)
    return code, raw.getvalue().decode("utf-8"), err.getvalue()


def _result(
    item: BatchItem, code: int, written: list[str], out: str, err: str, had_outputs: bool, seconds: float
) -> BatchResult:
    lines = err.splitlines()
    errors = [line.removeprefix(ERROR) for line in lines if line.startswith(ERROR)]
    warnings = [line.removeprefix(WARNING) for line in lines if line.startswith(WARNING)]
    notes = [line for line in lines if not line.startswith((ERROR, WARNING))]
    status: BatchStatus = "failed"
    if not errors and code in (0, 1):  # 1: findings
        status = "done"
    elif code in (EXIT_USAGE, EXIT_LIMIT) or (code == EXIT_OUTPUT and had_outputs):
        status = "refused"
    return BatchResult(
        item.inputs,
        tuple(written) if status == "done" else item.outputs,
        code,
        status,
        " ".join(errors),
        tuple(warnings),
        round(seconds, 4),
        item.recipe,
        tuple(notes),
        _report(out),
    )


def _report(text: str) -> Any:
    """What a command printed, parsed if it is JSON; None if it printed nothing."""
    if not text.strip():
        return None
    try:
        return json.loads(text)
    except ValueError:
        return text


def _unstarted(item: BatchItem, message: str) -> BatchResult:
    return BatchResult(item.inputs, item.outputs, EXIT_OUTPUT, "failed", message, recipe=item.recipe)

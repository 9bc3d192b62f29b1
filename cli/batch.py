"""``nmap batch``."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options.batch import BatchOptions
from nmaptool.types.batch import BatchJob, BatchResult
from nmaptool_cli.command import command
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.run import Run
from nmaptool_cli.streams import standard_output

# clears the line of the progress bar, which a JSON line on the same terminal would join
_CLEAR = "\r\x1b[2K"


@command(BatchOptions)
def batch(run: Run, /, *job: Annotated[str, Parameter(allow_leading_hyphen=True)]) -> int:
    """Run a command for many files, several at a time, and go on where an earlier run stopped.

    Quote patterns; {stem}, {name}, {parent} and {number} in outputs and other files stand for parts of each input's
    name. Prints one JSON line for each file. Exit code: the largest of all files; one that fails does not stop the
    others.

    Example: nmap batch relief 'maps/*.png' -o 'out/{stem}.stl' --height 4mm

    Parameters
    ----------
    job:
        A command (relief, bake, inspect, compose convert, ...), one or more files or patterns, and the flags of the
        command; or a table of jobs (.toml or .csv).
    """
    import nmaptool as nm
    from nmaptool.io.sets.tables import is_table, read_jobs
    from nmaptool_cli.sets.items import job_of_words

    jobs: Iterable[BatchJob]
    if job and is_table(job[0]):
        if len(job) > 1:
            raise UsageError(f"{job[1]}: a table of jobs holds all options; write it there")
        jobs = read_jobs(job[0])
    else:
        jobs = [job_of_words(job)]
    jobs = [replace(each, words=(*each.words, *_passed_on(run))) for each in jobs]
    codes: Counter[int] = Counter()
    found: Counter[str] = Counter()
    with run.progress() as progress:
        for result in nm.batch(jobs, run[BatchOptions], progress=progress):
            codes[result.exit_code] += 1
            found[result.status] += 1
            _print(result, run, shows_bar=progress is not None)
    run.say(f"nmap batch: {_summary(found)}")
    run.speak()
    return max(codes, default=0)


def _passed_on(run: Run) -> list[str]:
    """The flags of every command that the batch's own parser has taken."""
    return [flag for flag, given in (("-v", run.options.verbose), ("--json", run.options.json)) if given]


def _print(result: BatchResult, run: Run, *, shows_bar: bool) -> None:
    """Print the JSON line of an item; with -v also its messages."""
    if shows_bar:
        sys.stderr.write(_CLEAR)
        sys.stderr.flush()
    with standard_output() as stream:
        stream.write(json.dumps(result.to_dict(), ensure_ascii=False).encode("utf-8", "backslashreplace") + b"\n")
    if run.options.verbose and not run.options.quiet:
        for line in (*result.notes, *(f"nmap: warning: {text}" for text in result.warnings)):
            print(f"{result.inputs[0]}: {line.strip()}", file=sys.stderr)
    if result.status in ("failed", "refused"):
        print(in_flags(f"nmap: error: {result.message}"), file=sys.stderr)


def _summary(found: Counter[str]) -> str:
    count = sum(found.values())
    parts = [f"{found[status]} {status}" for status in ("done", "skipped", "refused", "failed") if found[status]]
    return f"{count} {'item' if count == 1 else 'items'}: {', '.join(parts) or 'nothing to do'}"

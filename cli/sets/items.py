"""The items of jobs: one run of a command for each input."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from nmaptool._version import __version__
from nmaptool.core.errors import InputError, NmaptoolError, UsageError
from nmaptool.io.sets.identity import files_of, identity
from nmaptool.io.sets.patterns import expand, fill, has_placeholder
from nmaptool.types.batch import BatchItem, BatchJob
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.sets.parsed import Parsed, flag_words, named_command, parse, split_words, takes_several
from nmaptool_cli.streams import STREAM, refuse_stream

_LONGEST_HASH = 32
_LIMIT = "memory_limit"
# they make names of files that the batch does not know beforehand, so it cannot tell whose files would be replaced
_PARTS = {"part", "parts"}


def job_of_words(words: Sequence[str]) -> BatchJob:
    """The job of a command line: a command, its inputs and its flags.

    Raises
    ------
    UsageError
        If the command is missing or unknown.
    """
    if not words or words[0].startswith("-"):
        raise UsageError("COMMAND is missing; name one, such as nmap batch relief 'maps/*.png', or a table of jobs")
    count = 2 if words[0] == "compose" else 1
    command = " ".join(words[:count])
    inputs, flags = split_words(command, words[count:])
    return BatchJob(command, tuple(inputs), words=tuple(flags))


def items_of(jobs: Iterable[BatchJob]) -> list[BatchItem]:
    """The items of all jobs, in order.

    Raises
    ------
    UsageError
        If a command, an option or a placeholder is not accepted, or two items have the same output.
    InputError
        If no file fits a pattern.
    """
    items = [item for job in jobs for item in _located(job)]
    _refuse_shared(items)
    return items


def ready(item: BatchItem, *, overwrite: bool, memory_limit: str | None) -> BatchItem:
    """The item with the flags that the batch adds: leave to replace its outputs, and the limit of memory."""
    flags = dict(item.flags)
    if overwrite and item.outputs and not _PARTS & flags.keys():
        flags["overwrite"] = True
    if memory_limit is not None and _LIMIT in named_command(item.command).option_names:
        flags.setdefault(_LIMIT, memory_limit)
    return dataclasses.replace(item, flags=flags)


def _located(job: BatchJob) -> Iterator[BatchItem]:
    """The items of one job; errors say where it is written."""
    try:
        yield from _items_of(job)
    except NmaptoolError as error:
        if job.place:
            error.args = (f"{job.place}: {in_flags(str(error))}", *error.args[1:])
        raise


def _items_of(job: BatchJob) -> Iterator[BatchItem]:
    flags = [*flag_words(job.command, job.options), *job.words]
    patterns, fixed = _patterns(job)
    refuse_stream("a batch reads files, so that it can go on where it stopped", *patterns, *fixed)
    parsed = parse(job.command, ["input", *fixed, *flags])
    refuse_stream("the items of a batch write files", *parsed.texts(outputs=True))
    for number, source in enumerate(expand(patterns, job.folder), start=1):
        yield _item(job, source, parsed.of(source, partial(fill, source=source, number=number)))


def _patterns(job: BatchJob) -> tuple[list[str], list[str]]:
    """The patterns whose files are the items, and the words that every item has after its input."""
    if not job.inputs:
        raise UsageError("no input given: name one or more, such as 'maps/*.png'")
    names = [STREAM if name == "-" else name for name in job.inputs]
    if takes_several(job.command):
        return names[:1], names[1:]
    fixed = [name for name in names if has_placeholder(name) and not (job.folder / name).exists()]
    patterns = [name for name in names if name not in fixed]
    if not patterns:
        raise UsageError(f"{fixed[0]}: an input may have * and ?, but placeholders are for outputs and other files")
    return patterns, fixed


def _item(job: BatchJob, source: str, parsed: Parsed) -> BatchItem:
    """One item, with what identifies it."""
    read = tuple(str(path) for path in files_of(parsed.texts(outputs=False), job.folder))
    facts = [job.command, parsed.lasting(), __version__, [identity(Path(name)) for name in read]]
    recipe = hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:_LONGEST_HASH]
    outputs = tuple(name for name in parsed.texts(outputs=True) if name != STREAM)
    folder = os.fspath(job.folder.absolute())
    return BatchItem(job.command, parsed.arguments, parsed.flags, (source,), read, outputs, recipe, folder, job.place)


def _refuse_shared(items: Sequence[BatchItem]) -> None:
    """Refuse two items with one output, and an output that is also an input."""
    owners: dict[str, BatchItem] = {}
    for item in items:
        for name in item.outputs:
            path = os.path.normcase(os.path.abspath(os.path.join(item.folder, name)))  # noqa: PTH100, PTH118 - keeps links
            other = owners.setdefault(path, item)
            if other is not item:
                raise UsageError(
                    f"{name}: is the output of {other.inputs[0]} and of {item.inputs[0]}; use {{stem}}, {{name}}, "
                    "{parent} or {number} in it"
                )
    for item in items:
        for name in item.files:
            owner = owners.get(os.path.normcase(os.path.abspath(name)))  # noqa: PTH100
            if owner is not None:
                raise InputError(
                    f"{name}: is an input and also an output of {owner.inputs[0]}; write outputs to another folder"
                )

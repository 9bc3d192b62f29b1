"""The journal of a batch: a file with a JSON line for each step, which a later run reads to go on."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from nmaptool.core.errors import InputError, OutputError, reason_of
from nmaptool.io.sets.identity import identity
from nmaptool.types.batch import BatchItem, BatchResult

JOURNAL_NAME = ".nmap-batch.jsonl"
_Signature = tuple[int, int]


def default_journal(items: Sequence[BatchItem]) -> Path | None:
    """Return the journal beside the outputs: in the deepest folder that holds all of them; None without outputs."""
    folders = {str(Path(item.folder, name).absolute().parent) for item in items for name in item.outputs}
    if not folders:
        return None
    try:
        return Path(os.path.commonpath(folders)) / JOURNAL_NAME
    except ValueError:  # different drives
        return Path(min(folders)) / JOURNAL_NAME


@dataclass(frozen=True)
class _Done:
    """A finished item: its outputs as they were when it ended, and its exit code."""

    outputs: dict[Path, _Signature]
    exit_code: int


@dataclass
class _State:
    """What the lines of a journal say.

    Attributes
    ----------
    done : dict
        Finished items by recipe.
    written : dict
        The last known state of every file that an item has written.
    begun : dict
        The outputs of items that have begun and not ended, by recipe.
    """

    done: dict[str, _Done] = field(default_factory=dict)
    written: dict[Path, _Signature] = field(default_factory=dict)
    begun: dict[str, set[Path]] = field(default_factory=dict)


class Journal:
    """The steps of a batch, on file or, without a path, in memory alone.

    Every line is written at once and at the end of the file, so that a batch that is killed leaves at most one
    incomplete line, which is ignored.

    Parameters
    ----------
    path : Path or None
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._folder = Path() if path is None else path.absolute().parent
        self._stream: BinaryIO | None = None
        self._state = _State()

    @contextlib.contextmanager
    def open(self) -> Iterator[Journal]:
        """Read the journal, and keep it open for this batch alone.

        Raises
        ------
        InputError
            If the file is not a journal.
        OutputError
            If it cannot be written, or another batch has it open.
        """
        if self.path is None:
            yield self
            return
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            stream = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise OutputError(f"{self.path}: the journal cannot be written ({reason_of(error)})") from None
        with stream:
            _lock(stream, self.path)
            stream.seek(0)
            data = stream.read()
            self._read(data)
            if data and not data.endswith(b"\n"):
                stream.write(b"\n")
            self._stream = stream
            try:
                yield self
            finally:
                self._stream = None

    def finished(self, item: BatchItem) -> BatchResult | None:
        """Return the result of an earlier run if the item is done, unchanged, and its outputs exist; otherwise None."""
        entry = self._state.done.get(item.recipe)
        if entry is None or not all(self._is_still(*output) for output in entry.outputs.items()):
            return None
        outputs = tuple(_shown(path, item) for path in entry.outputs)
        return BatchResult(item.inputs, outputs, entry.exit_code, "skipped", recipe=item.recipe)

    def owns(self, item: BatchItem) -> bool:
        """Whether everything at the outputs of an item, if anything, was written by this batch and is unchanged."""
        return all(self._is_ours(_absolute(item, name)) for name in item.outputs)

    def begin(self, item: BatchItem) -> None:
        """Record that an item may be writing its outputs from now on; only for outputs that the batch `owns`."""
        outputs = [_absolute(item, name) for name in item.outputs]
        self._state.begun[item.recipe] = set(outputs)
        self._write({"state": "begun", **self._facts(item), "outputs": [self._name(path) for path in outputs]})

    def end(self, item: BatchItem, result: BatchResult) -> None:
        """Record how an item ended."""
        self._state.begun.pop(item.recipe, None)
        if result.status != "done":
            self._write({"state": "failed", **self._facts(item)})
            return
        outputs = {path: _signature(path) for path in (_absolute(item, name) for name in result.outputs)}
        self._state.written |= outputs
        self._state.done[item.recipe] = _Done(outputs, result.exit_code)
        named = {self._name(path): signature for path, signature in outputs.items()}
        self._write({"state": "done", **self._facts(item), "outputs": named, "exit_code": result.exit_code})

    def _facts(self, item: BatchItem) -> dict[str, Any]:
        return {"recipe": item.recipe, "command": item.command, "inputs": item.inputs}

    def _is_ours(self, path: Path) -> bool:
        if not os.path.lexists(path) or self._is_begun(path):
            return True
        if self._state.written.get(path) == _signature(path):
            return True
        return path.is_dir() and all(self._is_ours(each) for each in path.iterdir())

    def _is_still(self, path: Path, signature: _Signature) -> bool:
        """Whether an output exists and no later item has written it."""
        return path.exists() and self._state.written.get(path) == signature and not self._is_begun(path)

    def _is_begun(self, path: Path) -> bool:
        """Whether an item that has not ended may have written this file, or the folder that it is in."""
        return any({path, *path.parents} & paths for paths in self._state.begun.values())

    def _name(self, path: Path) -> str:
        """Return a path relative to the journal, so that both can be moved together."""
        try:
            return Path(os.path.relpath(path, self._folder)).as_posix()
        except ValueError:  # another drive
            return str(path)

    def _read(self, data: bytes) -> None:
        state = _State()
        for number, line in enumerate(data.split(b"\n"), start=1):
            if not line.strip():
                continue
            try:
                self._take(state, json.loads(line))
            except (ValueError, KeyError, TypeError, AttributeError):
                if number == 1:
                    raise InputError(f"{self.path}: is not a journal of nmap batch; name another `journal`") from None
        self._state = state

    def _take(self, state: _State, entry: dict[str, Any]) -> None:
        recipe = entry["recipe"]
        match entry["state"]:
            case "begun":
                state.begun[recipe] = {self._path(name) for name in entry["outputs"]}
            case "done":
                state.begun.pop(recipe, None)
                outputs = {self._path(name): (int(size), int(time)) for name, (size, time) in entry["outputs"].items()}
                state.written |= outputs
                state.done[recipe] = _Done(outputs, int(entry["exit_code"]))
            case "failed":
                state.begun.pop(recipe, None)

    def _path(self, name: str) -> Path:
        return Path(os.path.normpath(self._folder / name))

    def _write(self, entry: dict[str, Any]) -> None:
        if self._stream is None:
            return
        try:
            self._stream.write(json.dumps(entry).encode() + b"\n")
        except OSError as error:
            raise OutputError(f"{self.path}: the journal cannot be written ({reason_of(error)})") from None


def _absolute(item: BatchItem, name: str) -> Path:
    return Path(os.path.abspath(os.path.join(item.folder, name)))  # noqa: PTH100, PTH118 - links stay


def _signature(path: Path) -> _Signature:
    _, size, time = identity(path)
    return size, time


def _shown(path: Path, item: BatchItem) -> str:
    """Return an output as the item names it."""
    for name in item.outputs:
        declared = _absolute(item, name)
        if path == declared or declared in path.parents:
            return name if path == declared else str(Path(name) / path.relative_to(declared))
    return str(path)


def _lock(stream: BinaryIO, path: Path) -> None:
    """Keep other batches from the file until it is closed, also by the end of the process."""
    try:
        if sys.platform == "win32":
            import msvcrt

            stream.seek(1 << 40)  # a byte that is never written: a locked one could not be read
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise _in_use(path) from None
    except PermissionError:
        raise _in_use(path) from None
    except OSError:  # a file system without locks
        return


def _in_use(path: Path) -> OutputError:
    return OutputError(f"{path}: another batch is using this journal; wait for its end, or name another `journal`")

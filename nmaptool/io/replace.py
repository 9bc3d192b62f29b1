"""Writing beside and renaming, so that no reader ever sees half a file and nothing is lost by a failed run."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator, Sequence
from pathlib import Path

from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.io.unfinished import all_or_none, files_are_done, unfinished


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a target that cannot be written, before any work is done.

    Raises
    ------
    OutputError
        If the folder is missing or not writable, the target is a folder, or it exists and ``overwrite`` is False.
    """
    folder = path.parent
    try:
        if path.is_dir():
            raise OutputError(f"{path}: is a folder; give a file name")
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"{path}: {folder} is a file, not a folder; give another place")
        if not folder.is_dir():
            raise OutputError(f"{path}: the folder {folder} does not exist; make it first")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(f"{path}: the folder {folder} cannot be written to")
        path.lstat()
    except FileNotFoundError:
        return
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None
    if not overwrite:
        raise _exists(path)


def check_targets(paths: Sequence[Path], overwrite: bool) -> None:
    """`check_target` of each, none of them named twice.

    Raises
    ------
    UsageError
        If two are the same file.
    OutputError
        As `check_target`.
    """
    seen: set[Path] = set()
    for path in paths:
        if path.resolve() in seen:
            raise UsageError(f"{path}: is named twice as an output")
        seen.add(path.resolve())
        check_target(path, overwrite)


def _exists(path: Path) -> OutputError:
    return OutputError(f"{path}: exists already; give another name, or --overwrite")


@contextlib.contextmanager
def written_beside(targets: list[Path], overwrite: bool, *, last: bool = True) -> Iterator[list[Path]]:
    """Paths beside ``targets`` to write to; renamed to them together when the block ends well, removed otherwise.

    Parameters
    ----------
    targets : list of Path
    overwrite : bool
        Whether targets that exist are replaced.
    last : bool
        Whether a command is done with them; False for what is only kept on the way.

    Raises
    ------
    OutputError
        As `check_target`, or if renaming fails: then every target is as it was before.
    """
    for target in targets:
        check_target(target, overwrite)
    mark = secrets.token_hex(4)
    # short names: the target's own may be as long as a name can be
    beside = [target.with_name(f".{mark}-{i}{target.suffix}") for i, target in enumerate(targets)]
    kept = [target.with_name(f".{mark}-{i}.kept") for i, target in enumerate(targets)]
    with unfinished(beside):
        try:
            yield beside
            with all_or_none():
                try:
                    _rename_all(beside, targets, kept, overwrite)
                finally:
                    for path in kept:
                        path.unlink(missing_ok=True)
                files_are_done(last)
        finally:
            for path in beside:
                path.unlink(missing_ok=True)


@contextlib.contextmanager
def named(target: Path, temporary: Path) -> Iterator[None]:
    """Errors of writing speak of the target, not of the file beside it."""
    try:
        yield
    except OutputError as error:
        raise OutputError(str(error).replace(str(temporary), str(target))) from None
    except OSError as error:
        raise OutputError(f"{target}: cannot be written ({reason_of(error)})") from None


def _rename_all(sources: list[Path], targets: list[Path], kept: list[Path], overwrite: bool) -> None:
    """Rename every source or none; what is replaced is kept aside until all went well."""
    begun: list[tuple[Path, Path, Path]] = []
    try:
        for source, target, old in zip(sources, targets, kept, strict=True):
            begun.append((source, target, old))
            if overwrite and target.exists():
                _keep(target, old)
                source.replace(target)
            else:
                _rename(source, target)
    except BaseException as error:
        for source, target, old in begun:
            if old.exists():
                old.replace(target)
            elif source.exists() and target.exists() and target.samefile(source):
                target.unlink()
        if isinstance(error, OSError) and not isinstance(error, OutputError):
            raise OutputError(f"{begun[-1][1]}: cannot be written ({reason_of(error)})") from None
        raise


def _keep(target: Path, old: Path) -> None:
    try:
        old.hardlink_to(target)  # the target never vanishes
    except OSError:  # a file system without hard links
        target.replace(old)


def _rename(source: Path, target: Path) -> None:
    try:
        target.hardlink_to(source)  # unlike rename, fails where the target has appeared meanwhile
    except FileExistsError:
        raise _exists(target) from None
    except OSError:  # a file system without hard links
        if target.exists():
            raise _exists(target) from None
        source.replace(target)

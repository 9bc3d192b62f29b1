"""Writing beside and renaming, so that no reader ever sees half a file and nothing is lost by a failed run."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from nmaptool.errors import OutputError


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a target that cannot be written, before any work is done.

    Raises
    ------
    OutputError
        If the folder is missing or not writable, the target is a folder, or it exists and ``overwrite`` is False.
    """
    folder = path.parent
    if path.is_dir():
        raise OutputError(f"{path}: is a folder; give a file name")
    if not folder.is_dir():
        raise OutputError(f"{path}: the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder} cannot be written to")
    if path.exists() and not overwrite:
        raise OutputError(f"{path}: exists already; give another name, or --overwrite")


@contextlib.contextmanager
def written_beside(targets: list[Path], overwrite: bool) -> Iterator[list[Path]]:
    """Paths beside ``targets`` to write to; renamed to them together when the block ends well, removed otherwise.

    Parameters
    ----------
    targets : list of Path
    overwrite : bool
        Whether targets that exist are replaced.

    Raises
    ------
    OutputError
        As `check_target`, or if renaming fails.
    """
    for target in targets:
        check_target(target, overwrite)
    mark = secrets.token_hex(4)
    beside = [target.with_name(f".{target.stem}.{mark}-{i}{target.suffix}") for i, target in enumerate(targets)]
    try:
        yield beside
        for source, target in zip(beside, targets, strict=True):
            _rename(source, target, overwrite)
    finally:
        for path in beside:
            path.unlink(missing_ok=True)


def _rename(source: Path, target: Path, overwrite: bool) -> None:
    try:
        if overwrite:
            source.replace(target)
            return
        try:
            target.hardlink_to(source)  # unlike rename, fails where the target has appeared meanwhile
        except FileExistsError:
            raise
        except OSError:  # a file system without hard links
            if target.exists():
                raise FileExistsError(target) from None
            source.replace(target)
    except FileExistsError:
        raise OutputError(f"{target}: exists already; give another name, or --overwrite") from None
    except OSError as error:
        raise OutputError(f"{target}: cannot be written ({error.strerror})") from None

"""Rename several files together, so that no reader sees half a file and a failed run loses nothing."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from nmaptool.core.errors import OutputError
from nmaptool.io.output.targets import cannot_be_written, exists_already


@contextlib.contextmanager
def renamed(sources: Sequence[Path], targets: Sequence[Path], overwrite: bool) -> Iterator[None]:
    """Rename every source to its target; if this or the block fails, restore every target.

    Parameters
    ----------
    sources : sequence of Path
        In the folders of their targets. Some of them may still exist afterwards.
    targets : sequence of Path
    overwrite : bool
        Whether to replace targets that exist.

    Raises
    ------
    OutputError
        If a file cannot be renamed, or a target exists and ``overwrite`` is False.
    """
    # replaced files are kept under another name until everything has succeeded
    moves = [
        (source, target, source.with_name(f"{source.stem}.kept"))
        for source, target in zip(sources, targets, strict=True)
    ]
    begun: list[tuple[Path, Path, Path]] = []
    try:
        for move in moves:
            begun.append(move)
            _rename(*move, overwrite)
        yield
    except BaseException:
        for move in begun:
            _take_back(*move)
        raise
    finally:
        for _, _, kept in moves:
            with contextlib.suppress(OSError):  # another program may have it open, which Windows does not allow
                kept.unlink(missing_ok=True)


def _rename(source: Path, target: Path, kept: Path, overwrite: bool) -> None:
    try:
        if overwrite and target.exists():
            _keep(target, kept)
            source.replace(target)
        else:
            _rename_to_new(source, target)
    except OutputError:
        raise
    except OSError as error:
        raise cannot_be_written(target, error) from None


def _keep(target: Path, kept: Path) -> None:
    try:
        kept.hardlink_to(target)  # so that the target never disappears
    except OSError:  # a file system without hard links
        target.replace(kept)


def _rename_to_new(source: Path, target: Path) -> None:
    try:
        target.hardlink_to(source)  # unlike rename, fails if the target has appeared in the meantime
    except FileExistsError:
        raise exists_already(target) from None
    except OSError:  # a file system without hard links
        if target.exists():
            raise exists_already(target) from None
        source.replace(target)


def _take_back(source: Path, target: Path, kept: Path) -> None:
    if kept.exists():
        kept.replace(target)
    elif not source.exists() or (target.exists() and target.samefile(source)):
        target.unlink(missing_ok=True)

"""What editing commands share on maps larger than memory."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from nmaptool.core.errors import UsageError
from nmaptool.io.stores.recognition import is_large_map
from nmaptool.options import TilingOptions
from nmaptool.options.formats import LARGE_ENDING
from nmaptool_cli.outputs import ReportOutputs
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    from nmaptool.core.progress import Progress
    from nmaptool.types.tiled_edit import TiledEdit

_Made = TypeVar("_Made")
_URL = re.compile(r"^(\w{2,}):/(?!/)")


def is_large(run: Run, output: Path | None, *names: str | None, max_megapixels: float) -> bool:
    """Whether a command works by tiles: an input is a store, or the output is to be one.

    Parameters
    ----------
    run : Run
    output : Path, optional
    *names : str, optional
        Inputs.
    max_megapixels : float
        TIFF files with more are large.

    Raises
    ------
    UsageError
        If options of large maps are given for a map that is not.
    """
    if output is not None and output.suffix.lower() == LARGE_ENDING:
        return True
    if any(is_large_map(name, max_megapixels) for name in names if name is not None):
        return True
    for name in run.named(TilingOptions):
        raise UsageError(f"`{name}`: is for large maps: Zarr stores, folders of tiles and large TIFF files")
    return False


def store_name(output: Path | None) -> str:
    """The name of the store to write, as it was given; a path has only one slash after the scheme of a URL.

    Raises
    ------
    UsageError
        If there is none.
    """
    if output is None:
        raise UsageError("no output given: add one, such as -o map.zarr")
    return _URL.sub(r"\1://", str(output))


def refuse_for_large(given: Mapping[str, Any]) -> None:
    """Refuse options that need the whole map in memory.

    Parameters
    ----------
    given : mapping
        Options and their values; those that are false or None were not given.

    Raises
    ------
    UsageError
    """
    for name, value in given.items():
        if value:
            raise UsageError(f"`{name}`: is not for large maps; leave it out")


def edit_large(run: Run, flags: ReportOutputs, edit: Callable[[Progress | None], _Made], **inputs: Any) -> _Made:
    """Run an edit with a progress bar; the names of its inputs go into the report."""
    run.begin(_report_of(flags), **inputs)
    with run.progress() as progress:
        return edit(progress)


def finish_large(run: Run, flags: ReportOutputs, made: TiledEdit[Any], **facts: Any) -> None:
    """Say what was done, and write the report."""
    from nmaptool_cli.wording.large_edits import describe_edit

    describe_edit(run, made)
    metadata = run.header(**facts) | made.to_dict()
    run.finish(_report_of(flags), None, metadata, written=(made.output,))


def _report_of(flags: ReportOutputs) -> Any:
    from nmaptool.io.output.transaction import Outputs

    return Outputs((), **flags.shared)

"""Write pictures to Zarr stores under another name, which are renamed when they are complete; and their pyramids."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.stores.extra import fsspec_module, zarr_module
from nmaptool.io.stores.names import ZARR_ENDING, local_path, split_name
from nmaptool.io.stores.picture_plan import Make, PicturePlan
from nmaptool.io.stores.reducing import Reducer, reduced_shape
from nmaptool.io.stores.windows import grid_windows
from nmaptool.io.stores.zarr_nodes import OWN, location_of
from nmaptool.io.stores.zarr_pictures import ZarrPicture
from nmaptool.io.stores.zarr_writing import INNER, ZarrWriter, create_picture, make_room

# a pyramid ends with the first level that is not longer than this
_SMALLEST_PX = 512
# attributes that hold for all pixels of one size only
_OF_ONE_SIZE = ("pitch_mm", "at")


def write_zarr(name: str, plan: PicturePlan, make: Make, chunk: int, *, pyramid: bool, overwrite: bool) -> None:
    """Write a picture to a Zarr store window by window.

    Parameters
    ----------
    name : str
        Path or URL.
    plan : PicturePlan
    make : callable
    chunk : int
        Side of a shard.
    pyramid : bool
        Write a group with the picture as array 0, and smaller versions as 1, 2, ...
    overwrite : bool
        Replace a store that exists.

    Raises
    ------
    UsageError
        If the name is that of an array in a group.
    OutputError
        If it cannot be written.
    """
    if split_name(name).layer is not None:
        raise UsageError(f"{name}: names an array in a group; give a store of its own, such as map.zarr")
    with _replacing(name, overwrite) as unfinished:
        first = f"{unfinished}:0" if pyramid else unfinished
        store = _created(first, plan, chunk)
        for rows, cols in grid_windows((plan.rows, plan.cols), store.chunk):
            store.write(rows.start, cols.start, make(rows, cols))
        if pyramid:
            _write_levels(unfinished, plan, chunk)


def level_attributes(attributes: Mapping[str, str], pitch_mm: float | None, factor: int) -> dict[str, str]:
    """The attributes of a version whose pixels are ``factor`` times as large."""
    if factor == 1:
        return dict(attributes)
    kept = {key: text for key, text in attributes.items() if key not in _OF_ONE_SIZE}
    return kept if pitch_mm is None else {**kept, "pitch_mm": repr(pitch_mm * factor)}


def _created(name: str, plan: PicturePlan, chunk: int) -> ZarrWriter:
    inner = next((size for size in (INNER, 256, 128, 64, 32, 16) if chunk % size == 0), chunk)
    return create_picture(
        name,
        plan.rows,
        plan.cols,
        plan.channels,
        plan.dtype,
        chunk=chunk,
        inner=inner,
        pitch_mm=plan.pitch_mm,
        attributes=plan.attributes,
    )


def _write_levels(group: str, plan: PicturePlan, chunk: int) -> None:
    """Add versions of half the size of the one before to a group."""
    number, rows, cols = 0, plan.rows, plan.cols
    while max(rows, cols) > _SMALLEST_PX:
        reducer = Reducer(ZarrPicture(group, str(number)), 2)
        (rows, cols), number = reduced_shape(rows, cols, 2), number + 1
        pitch_mm = None if plan.pitch_mm is None else plan.pitch_mm * 2**number
        attributes = level_attributes(plan.attributes, None, 2)
        level = PicturePlan(rows, cols, plan.channels, plan.dtype, pitch_mm, attributes)
        store = _created(f"{group}:{number}", level, chunk)
        for down, across in grid_windows((rows, cols), store.chunk):
            store.write(down.start, across.start, reducer.window(down, across).astype(plan.dtype, copy=False))
    root = zarr_module(group).open_group(location_of(group), mode="r+")
    root.attrs[OWN] = {"pyramid": [str(level) for level in range(number + 1)]}


@contextlib.contextmanager
def _replacing(name: str, overwrite: bool) -> Iterator[str]:
    """A name under which to write a store; at the end it gets its own, and if the block fails it is removed."""
    path, mark = local_path(name), secrets.token_hex(4)
    if path is None:
        unfinished = f"{name.removesuffix(ZARR_ENDING)}.{mark}{ZARR_ENDING}"
        with _removed_at_address(unfinished):
            yield unfinished
            make_room(name, overwrite)
            files, source = fsspec_module(name).core.url_to_fs(unfinished)
            files.mv(source, files._strip_protocol(name), recursive=True)
        return
    hidden = path.parent / f".{mark}-0{ZARR_ENDING}"
    with UNFINISHED.swept_tree(hidden):
        try:
            yield str(hidden)
            _publish(name, path, hidden, overwrite)
        except OutputError as error:
            raise OutputError(str(error).replace(str(hidden), name)) from None
        finally:
            shutil.rmtree(hidden, ignore_errors=True)


@contextlib.contextmanager
def _removed_at_address(unfinished: str) -> Iterator[None]:
    """Remove an unfinished store at a URL if the block fails."""
    try:
        yield
    except BaseException:
        files, root = fsspec_module(unfinished).core.url_to_fs(unfinished)
        with contextlib.suppress(OSError):
            files.rm(root, recursive=True)
        raise


def _publish(name: str, path: Path, hidden: Path, overwrite: bool) -> None:
    """Give a complete store its name; one that it replaces is removed after that."""
    make_room(name, overwrite, remove=False)
    kept = hidden.with_suffix(".kept")
    with UNFINISHED.all_or_none():
        try:
            if path.exists():
                path.rename(kept)
            hidden.rename(path)
        except OSError as error:
            if kept.exists() and not path.exists():
                kept.rename(path)
            raise OutputError(f"{name}: cannot be written ({reason_of(error)})") from None
    shutil.rmtree(kept, ignore_errors=True)

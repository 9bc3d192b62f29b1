"""Write pictures larger than memory by windows: Zarr stores, folders of tiles, BigTIFF; all of it or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import OutputError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.output.targets import check_folders, check_places
from nmaptool.io.output.writing import write_together
from nmaptool.io.pictures.metadata import PREFIX, one_line
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.names import output_kind
from nmaptool.io.stores.picture_plan import Make, PicturePlan
from nmaptool.io.stores.tiles import tiles_in
from nmaptool.io.stores.windows import grid_windows
from nmaptool.io.stores.zarr_output import write_zarr
from nmaptool.io.stores.zarr_writing import CHUNK, make_room

TIFF_TILE_PX = 512
# tiles of a TIFF that are made at once
_TILES_AT_ONCE = 4
# what a TIFF of 32-bit offsets can hold, less its directory
_CLASSIC_BYTES = (1 << 32) - (1 << 25)


def check_output(name: str, *, pyramid: bool = False, overwrite: bool = False) -> None:
    """Refuse an output that could not be written, before any work.

    Parameters
    ----------
    name : str
        Of any kind; what `output_kind` does not know is a file.
    pyramid, overwrite : bool
        As for `write_windows`.

    Raises
    ------
    UsageError, OutputError
    """
    kind = output_kind(name)
    if pyramid and kind != "zarr":
        raise UsageError(f"{name}: `pyramid`: smaller versions are written into Zarr stores; name one in .zarr")
    if kind == "zarr":
        make_room(name.rstrip("/"), overwrite, remove=False)
    elif kind == "tiles":
        folder = Path(name)
        check_folders([folder], "tiles are written into a folder; give another name")
        if not overwrite and folder.is_dir() and any(folder.iterdir()):
            raise OutputError(f"{folder}: is not empty; give another folder, or `overwrite`")
    else:
        check_places([Path(name)], overwrite)


def write_windows(
    name: str,
    plan: PicturePlan,
    make: Make,
    *,
    tile: int | None = None,
    pyramid: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write a picture window by window, in memory that does not depend on its size.

    Parameters
    ----------
    name : str
        Path or URL of a Zarr store, which ends in .zarr; a .tif, which becomes a BigTIFF in tiles if a TIFF could not
        hold it; or a folder for tiles ``tile_ROW_COLUMN``, .png for integers and .exr for floats.
    plan : PicturePlan
    make : callable
        Called with the rows and columns of each window, once for each, in any order.
    tile : int, optional
        Side of a tile, or of a shard of a Zarr store. Default: 2048; in a TIFF 512.
    pyramid : bool
        In a Zarr store, which becomes a group: add smaller versions, each of half the size, up to 512 px.
    overwrite : bool
        Replace what exists.
    progress : callable, optional
        Called with "writing" and the share done.

    Raises
    ------
    UsageError
        If the name does not say what to write, or the side of a tile is not accepted.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.
    """
    kind = output_kind(name)
    check_output(name, pyramid=pyramid, overwrite=overwrite)
    counted = _counted(plan, make, progress)
    if kind == "zarr":
        write_zarr(name.rstrip("/"), plan, counted, tile or CHUNK, pyramid=pyramid, overwrite=overwrite)
    elif kind == "tiles":
        jobs = list(_tile_jobs(Path(name), plan, counted, tile or CHUNK))
        _refuse_other_tiles(Path(name), {place.name for place, _ in jobs})
        write_together(jobs, overwrite, [Path(name)])
    elif kind == "tiff":
        side = tile or TIFF_TILE_PX
        if side % 16:
            raise UsageError(f"`tile={side}`: must be a multiple of 16 for a TIFF, such as `tile=512`")
        write_together([(Path(name), partial(_write_tiff, plan, counted, side))], overwrite)
    else:
        raise UsageError(f"{name}: a large picture is written to a Zarr store (.zarr), a .tif, or a folder of tiles")


def _counted(plan: PicturePlan, make: Make, progress: Progress | None) -> Make:
    """``make`` that reports the share of pixels made."""
    done = 0

    def made(rows: slice, cols: slice) -> NDArray[Any]:
        nonlocal done
        values = make(rows, cols)
        done += values.shape[0] * values.shape[1]
        if progress is not None:
            progress("writing", min(1.0, done / (plan.rows * plan.cols)))
        return values

    return made


def _refuse_other_tiles(folder: Path, names: set[str]) -> None:
    """Refuse a folder with tiles that would remain beside the new ones."""
    others = sorted(one.name for one in tiles_in(folder) if one.name not in names)
    if others:
        raise OutputError(f"{folder}: holds tiles of another picture, such as {others[0]}; remove them first")


def _tile_jobs(
    folder: Path, plan: PicturePlan, make: Make, side: int
) -> Iterator[tuple[Path, Callable[[Path], object]]]:
    ending = ".png" if plan.dtype.kind == "u" else ".exr"
    for rows, cols in grid_windows((plan.rows, plan.cols), (side, side)):
        place = folder / f"tile_{rows.start // side}_{cols.start // side}{ending}"
        yield place, partial(_write_tile, plan, make, (rows, cols))


def _write_tile(plan: PicturePlan, make: Make, window: tuple[slice, slice], path: Path) -> None:
    values = make(*window)
    half = values.dtype == np.float16
    pixels = values.astype(np.float32) if half else values
    write_image(_with_channels(pixels), path, plan.channels, plan.file_attributes, half=half)


def _with_channels(values: NDArray[Any]) -> NDArray[Any]:
    return values[..., None] if values.ndim == 2 else values


def _write_tiff(plan: PicturePlan, make: Make, side: int, path: Path) -> None:
    import tifffile

    count = len(plan.channels)
    size = plan.rows * plan.cols * count * plan.dtype.itemsize
    lines = (f"{PREFIX}{key}={one_line(value)}" for key, value in plan.file_attributes.items())
    colors = count - ("A" in plan.channels)
    extra = ["unassalpha"] if "A" in plan.channels else []
    extra = ["unspecified"] * (colors - 1) + extra if colors == 2 else extra
    with tifffile.TiffWriter(path, bigtiff=size > _CLASSIC_BYTES) as tiff:
        tiff.write(
            _tiff_tiles(plan, make, side),
            shape=(plan.rows, plan.cols, count) if count > 1 else (plan.rows, plan.cols),
            dtype=plan.dtype,
            tile=(side, side),
            photometric="rgb" if colors >= 3 else "minisblack",
            planarconfig="contig" if count > 1 else None,
            extrasamples=extra or None,
            compression="zlib",
            compressionargs={"level": 1},
            description="\n".join(lines).encode(),
            software="nmaptool",
            metadata=None,
        )


def _tiff_tiles(plan: PicturePlan, make: Make, side: int) -> Iterator[NDArray[Any]]:
    """The tiles row by row; those at the right and the lower edge are filled up."""
    count = len(plan.channels)
    for rows, cols in grid_windows((plan.rows, plan.cols), (side, _TILES_AT_ONCE * side)):
        values = _with_channels(make(rows, cols))
        for left in range(0, values.shape[1], side):
            part = values[:, left : left + side]
            tile = np.zeros((side, side, count), plan.dtype)
            tile[: part.shape[0], : part.shape[1]] = part
            yield tile if count > 1 else tile[..., 0]

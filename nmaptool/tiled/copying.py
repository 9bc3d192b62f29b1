"""Copy pictures larger than memory between stores and files."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.stores.names import local_path, output_kind, split_name
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.picture_output import check_output, write_windows
from nmaptool.io.stores.picture_plan import PicturePlan


def copy(
    source: str,
    output: str,
    *,
    tile: int | None = None,
    pyramid: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> None:
    """Copy a picture by windows as it is stored: a mask, a map of weights, heights, or a normal map.

    Parameters
    ----------
    source, output : str
        As for `nmaptool.tiled.convert`; the output is a Zarr store, a TIFF or a folder of tiles.
    tile, pyramid, overwrite, progress
        As for `nmaptool.tiled.convert`.

    Raises
    ------
    UsageError, InputError, OutputError
        As `nmaptool.tiled.convert`.

    Examples
    --------
    >>> nm.tiled.copy("samples/leaf_mask.png", "mask_tiles", tile=100)
    >>> nm.tiled.overview("mask_tiles", 56)
    <RasterImage mask_tiles: 56 x 56 px, pitch unknown, channels Y, 8-bit codes>
    """
    if output_kind(output) is None:
        raise UsageError(f"{output}: a picture is copied to a Zarr store (.zarr), a .tif, or a folder of tiles")
    refuse_same(source, output)
    check_output(output, pyramid=pyramid, overwrite=overwrite)
    picture = open_picture(source, holds="grey")
    corner = picture.read(slice(0, 1), slice(0, 1))
    is_half = corner.is_float and corner.bits == 16
    attributes = {key: text for key, text in picture.attributes.items() if key != "pitch_mm"}
    plan = PicturePlan(
        picture.rows,
        picture.cols,
        picture.channels,
        np.dtype(np.float16) if is_half and output_kind(output) != "tiff" else corner.pixels.dtype,
        picture.pitch_mm,
        attributes,
    )

    def make(rows: slice, cols: slice) -> NDArray[Any]:
        return picture.read(rows, cols).pixels.astype(plan.dtype, copy=False)

    write_windows(output, plan, make, tile=tile, pyramid=pyramid, overwrite=overwrite, progress=progress)


def refuse_same(source: str, output: str) -> None:
    """Refuse to write over the source.

    Raises
    ------
    UsageError
    """
    first, second = local_path(split_name(source).place), local_path(output.rstrip("/"))
    if first is None or second is None:
        same = source.rstrip("/") == output.rstrip("/")
    else:
        same = first.exists() and second.exists() and first.samefile(second)
    if same:
        raise UsageError(f"{source}: is also the output; give another name for the output")

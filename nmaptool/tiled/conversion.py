"""Convert normal maps larger than memory between stores and files, and copy other pictures."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.conversion import source_facts
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.output.conversion import kept_attributes, recipe_of
from nmaptool.io.output.writing import write_together
from nmaptool.io.pictures.normal_maps import map_attributes
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.names import output_kind
from nmaptool.io.stores.normal_maps import NormalMapStore, open_normal_map
from nmaptool.io.stores.picture_output import check_output, write_windows
from nmaptool.io.stores.picture_plan import Make, PicturePlan
from nmaptool.io.stores.windows import grid_windows
from nmaptool.maps.zero_code import ZERO_CODES
from nmaptool.options import Bits, ReadOptions, WriteOptions
from nmaptool.options.formats import NORMAL_MAP_FORMATS, check_ending
from nmaptool.options.plain_values import plain_values
from nmaptool.tiled.copying import refuse_same
from nmaptool.tiled.window_conversion import Sums, converted_window, depth_of, with_checked_zero
from nmaptool.types.conversion import ConvertReport
from nmaptool.types.picture import RasterImage

_DTYPES: dict[str, Any] = {"8": np.uint8, "16": np.uint16, "half": np.float16, "float": np.float32}
_BLOCK_PX = 2048
# bits by the kind of output, the usual first
_BITS: dict[str, tuple[Bits, ...]] = {
    "zarr": ("16", "8", "half", "float"),
    "tiles": ("16", "8", "half", "float"),
    "tiff": ("16", "8", "float"),
}


def convert(
    source: str,
    output: str,
    reading: ReadOptions | None = None,
    writing: WriteOptions | None = None,
    *,
    tile: int | None = None,
    pyramid: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> ConvertReport:
    """Convert a normal map by windows, as `nmaptool.convert` does in memory.

    Parameters
    ----------
    source : str
        A Zarr store, a folder of tiles, a TIFF or another picture file.
    output : str
        By ending: ``.zarr`` a Zarr store; ``.tif`` a TIFF in tiles, a BigTIFF if it is large; without an ending, or
        with a slash at the end, a folder of tiles, ``.png`` for codes and ``.exr`` for floats; ``.png`` or ``.exr``
        one file, which must fit in memory.
    reading : ReadOptions, optional
    writing : WriteOptions, optional
        ``bits`` "auto" is 16 bits; floats for ``.exr``.
    tile : int, optional
        Side of a tile, or of a shard of a Zarr store. Default: 2048, in a TIFF 512.
    pyramid : bool
        In a Zarr store, which becomes a group: add smaller versions, each of half the size, up to 512 px.
    overwrite : bool
        Replace an output that exists.
    progress : callable, optional
        Called with "writing" and the share done.

    Returns
    -------
    ConvertReport

    Raises
    ------
    UsageError
        If the ending or the bits are not supported, or the output is the source.
    InputError
        If the source cannot be read or is not a normal map.
    LimitError
        If the output is one file that cannot hold the map.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> report = nm.tiled.convert("samples/medal_base.png", "base_tiles", tile=128)
    >>> nm.tiled.convert("base_tiles", "base.tif").target["alpha"]
    True
    """
    reading, writing = reading or ReadOptions(), writing or WriteOptions()
    bits = _bits_for(output, writing)
    refuse_same(source, output)
    check_output(output, pyramid=pyramid, overwrite=overwrite)
    start = time.perf_counter()
    store = with_checked_zero(open_normal_map(source, reading))
    _check_size(store, output, reading)
    own = store.settled.zero_code if store.decoding.zero_code in ZERO_CODES else "127.5"
    zero = own if writing.write_zero_code == "auto" else writing.write_zero_code
    settled = replace(writing, bits=bits, write_zero_code=zero)
    corner = store.picture.read(slice(0, 1), slice(0, 1))
    options = {**plain_values(reading), **plain_values(settled)}
    plan, sums = _plan(store, corner, settled, options), Sums()
    has_alpha = "A" in plan.channels

    def make(rows: slice, cols: slice) -> NDArray[Any]:
        return converted_window(store, settled, sums, has_alpha, (rows, cols))

    if output_kind(output) is None:
        _write_whole(output, plan, make, overwrite, progress)
    else:
        write_windows(output, plan, make, tile=tile, pyramid=pyramid, overwrite=overwrite, progress=progress)
    return ConvertReport(
        command="convert",
        options=options,
        curl_before=sums.curl_before / max(1, sums.vertices),
        curl_after=sums.curl_after / max(1, sums.vertices),
        seconds={"convert": round(time.perf_counter() - start, 4)},
        warnings=store.decoding.warnings,
        source=source_facts(corner, store.decoding),
        target={
            "bits": bits,
            "green": settled.write_green,
            "zero_code": zero if bits in ("8", "16") else "0",
            "alpha": has_alpha,
        },
        vectors=sums.vectors,
        off_length=sums.off_length,
        off_length_largest=sums.off_length_largest,
        rim_pixels=sums.rim_pixels,
    )


def _plan(store: NormalMapStore, corner: RasterImage, writing: WriteOptions, options: dict[str, Any]) -> PicturePlan:
    """What the converted map is like; it has alpha if the map has a background."""
    has_alpha = store.settled.background_color != "none"
    own = map_attributes(depth_of(writing.bits), green=writing.write_green, zero_code=writing.write_zero_code)
    recipe = recipe_of(corner.attributes.get("recipe"), "convert", options)
    return PicturePlan(
        store.rows,
        store.cols,
        ("R", "G", "B", "A") if has_alpha else ("R", "G", "B"),
        np.dtype(_DTYPES[writing.bits]),
        store.pitch_mm,
        {**kept_attributes(corner), **own, "recipe": recipe},
    )


def _bits_for(output: str, writing: WriteOptions) -> Bits:
    """The bits to write.

    Raises
    ------
    UsageError
        If the output cannot hold them.
    """
    kind = output_kind(output)
    if kind is None:
        place = Path(output)
        check_ending(place, NORMAL_MAP_FORMATS, "normal maps")
        offered: tuple[str, ...] = NORMAL_MAP_FORMATS[place.suffix.lower()].bits
    else:
        offered = _BITS[kind]
    if writing.bits not in ("auto", *offered):
        raise UsageError(f"{output}: `bits={writing.bits!r}` is not supported for it; use {' or '.join(offered)}")
    return cast("Bits", offered[0]) if writing.bits == "auto" else writing.bits


def _check_size(store: NormalMapStore, output: str, reading: ReadOptions) -> None:
    """Refuse one file for a map that would have to be in memory for it.

    Raises
    ------
    LimitError
    """
    if output_kind(output) is None and store.rows * store.cols > reading.max_megapixels * 1e6:
        raise LimitError(
            f"{output}: {store.cols} x {store.rows} does not fit in one {Path(output).suffix} file; write a .tif, a "
            ".zarr, or tiles into a folder"
        )


def _write_whole(output: str, plan: PicturePlan, make: Make, overwrite: bool, progress: Progress | None) -> None:
    """Write one file of a map that fits in memory."""
    pixels = np.empty((plan.rows, plan.cols, len(plan.channels)), plan.dtype)
    for rows, cols in grid_windows((plan.rows, plan.cols), (_BLOCK_PX, _BLOCK_PX)):
        pixels[rows, cols] = make(rows, cols)
        if progress is not None:
            progress("writing", rows.stop / plan.rows)
    half = plan.dtype == np.float16
    values = pixels.astype(np.float32) if half else pixels

    def write(path: Path) -> None:
        write_image(values, path, plan.channels, plan.file_attributes, half=half)

    write_together([(Path(output), write)], overwrite)

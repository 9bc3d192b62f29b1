"""Convert normal maps larger than memory between stores and files, and copy other pictures."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.conversion import as_written, kept_where_sound, middle_fits_better, source_facts
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.core.vectors import inner_vertices, mean_abs_curl, unit
from nmaptool.io.output.conversion import kept_attributes, recipe_of
from nmaptool.io.output.writing import write_together
from nmaptool.io.pictures.normal_maps import map_attributes
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.names import local_path, split_name
from nmaptool.io.stores.normal_maps import NormalMapStore, open_normal_map
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.picture_output import Make, PicturePlan, check_output, output_kind, write_windows
from nmaptool.io.stores.sampling import sample_of
from nmaptool.io.stores.windows import grid_windows, widened, within
from nmaptool.maps import codec
from nmaptool.maps.decoding import Decoded
from nmaptool.maps.windows import WINDOW_MARGIN_PX, decode_window_as_stored
from nmaptool.maps.zero_code import ZERO_CODES
from nmaptool.options import Bits, ReadOptions, WriteOptions
from nmaptool.options.formats import NORMAL_MAP_FORMATS, check_ending
from nmaptool.options.plain_values import plain_values
from nmaptool.types.conversion import ConvertReport

_DTYPES: dict[str, Any] = {"8": np.uint8, "16": np.uint16, "half": np.float16, "float": np.float32}
_BLOCK_PX = 2048
Window: TypeAlias = tuple[slice, slice]
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
    """
    reading, writing = reading or ReadOptions(), writing or WriteOptions()
    bits = _bits_for(output, writing)
    _refuse_same(source, output)
    check_output(output, plan_free=True, overwrite=overwrite)
    start = time.perf_counter()
    store = open_normal_map(source, reading)
    _check_size(store, output, reading)
    store = _with_checked_zero(store)
    zero: Any = writing.write_zero_code
    if zero == "auto":
        zero = store.settled.zero_code if store.decoding.zero_code in ZERO_CODES else "127.5"
    settled = replace(writing, bits=bits, write_zero_code=zero)
    sums = _Sums()
    has_alpha = store.settled.background_color != "none"
    corner = store.picture.read(slice(0, 1), slice(0, 1))
    options = {**plain_values(reading), **plain_values(settled)}
    plan = PicturePlan(
        store.rows,
        store.cols,
        ("R", "G", "B", "A") if has_alpha else ("R", "G", "B"),
        np.dtype(_DTYPES[bits]),
        store.pitch_mm,
        {
            **kept_attributes(corner),
            **map_attributes(_depth(bits), green=settled.write_green, zero_code=zero),
            "recipe": recipe_of(corner.attributes.get("recipe"), "convert", options),
        },
    )

    def make(rows: slice, cols: slice) -> NDArray[Any]:
        return _converted(store, settled, sums, has_alpha, (rows, cols))

    if output_kind(output) is None:
        _write_whole(output, plan, make, overwrite, progress)
    else:
        write_windows(output, plan, make, tile=tile, overwrite=overwrite, progress=progress)
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


def copy(
    source: str, output: str, *, tile: int | None = None, overwrite: bool = False, progress: Progress | None = None
) -> None:
    """Copy a picture by windows as it is stored: a mask, a map of weights, heights, or a normal map.

    Parameters
    ----------
    source, output : str
        As for `convert`; the output is a Zarr store, a TIFF or a folder of tiles.
    tile, overwrite, progress
        As for `convert`.

    Raises
    ------
    UsageError, InputError, OutputError
        As `convert`.
    """
    if output_kind(output) is None:
        raise UsageError(f"{output}: a picture is copied to a Zarr store (.zarr), a .tif, or a folder of tiles")
    _refuse_same(source, output)
    check_output(output, plan_free=True, overwrite=overwrite)
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

    write_windows(output, plan, make, tile=tile, overwrite=overwrite, progress=progress)


@dataclass
class _Sums:
    """What the windows of a conversion add up to; as in `nmaptool.ConvertReport`, and the sums of curls."""

    vectors: int = 0
    off_length: int = 0
    off_length_largest: float = 0.0
    rim_pixels: int = 0
    curl_before: float = 0.0
    curl_after: float = 0.0
    vertices: int = 0

    def add(self, decoded: Decoded, off: NDArray[np.bool_], inner: Window) -> None:
        """Count the vectors of a window and those of odd length."""
        wrong = decoded.stored[inner][off[inner]].astype(np.float64)
        self.vectors += int(np.count_nonzero(decoded.normal_map.coverage[inner] > 0))
        self.off_length += len(wrong)
        largest = float(np.abs(np.sqrt(np.einsum("ij,ij->i", wrong, wrong)) - 1).max(initial=0))
        self.off_length_largest = max(self.off_length_largest, largest)


def _converted(
    store: NormalMapStore, writing: WriteOptions, sums: _Sums, has_alpha: bool, window: Window
) -> NDArray[Any]:
    """The codes of a window of the converted map."""
    shape = (store.rows, store.cols)
    rows, cols = (slice(part.start, min(part.stop + 1, size)) for part, size in zip(window, shape, strict=True))
    more = (rows, cols)  # a row and a column more, for the curl between windows
    around = widened(more, 0 if store.settled.background_color == "none" else WINDOW_MARGIN_PX, shape)
    image = store.picture.read(*around)
    whole, repaired = decode_window_as_stored(image, store.settled, store.decoding, (around[0].start, around[1].start))
    decoded = _cropped(whole, within(more, around))
    read = decoded.normal_map
    as_stored = unit(decoded.stored)
    untouched = (read.normals == as_stored).all(axis=-1)
    normals, off, _ = kept_where_sound(image, decoded, untouched)
    inner = (slice(window[0].stop - window[0].start), slice(window[1].stop - window[1].start))
    sums.add(decoded, off, inner)
    sums.rim_pixels += int(np.count_nonzero(repaired[within(window, around)]))
    count = int(np.count_nonzero(inner_vertices(read.foreground)))
    sums.vertices += count
    sums.curl_before += count * mean_abs_curl(as_stored, read.foreground)
    sums.curl_after += count * mean_abs_curl(as_written(normals, writing), read.foreground)
    codes = codec.encode_map(
        np.ascontiguousarray(normals[inner]),
        np.ascontiguousarray(read.coverage[inner]) if has_alpha else None,
        _depth(writing.bits),
        green=writing.write_green,
        zero_code=writing.write_zero_code,
    )
    return codes.astype(np.float16) if writing.bits == "half" else codes


def _cropped(decoded: Decoded, place: Window) -> Decoded:
    """A part of a decoded window; its channels and its background stay those of the window."""
    read = decoded.normal_map
    coverage = np.ascontiguousarray(read.coverage[place])
    part = replace(
        read,
        normals=np.ascontiguousarray(read.normals[place]),
        coverage=coverage,
        foreground=np.ascontiguousarray(read.foreground[place]),
        frame=replace(read.frame, rows=coverage.shape[0], cols=coverage.shape[1]),
    )
    return replace(decoded, stored=np.ascontiguousarray(decoded.stored[place]), normal_map=part)


def _with_checked_zero(store: NormalMapStore) -> NormalMapStore:
    """The store read with the zero code in the middle, if lengths contradict one that flat pixels suggested."""
    if store.decoding.zero_code_from != "found":
        return store
    sample, _ = sample_of(store.picture, lambda image, first: None)
    decoded, _ = decode_window_as_stored(sample, store.settled, store.decoding)
    if not middle_fits_better(decoded):
        return store
    middle = replace(store.decoding, zero_code="127.5")
    return NormalMapStore(store.picture, replace(store.settled, zero_code="127.5"), middle)


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


def _depth(bits: Bits) -> int:
    """Bits of integer codes; 32 for floats."""
    return 32 if bits in ("half", "float") else int(bits)


def _refuse_same(source: str, output: str) -> None:
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

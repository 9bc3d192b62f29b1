"""Write heights larger than memory to files that other programs read: BigTIFF, tiles of PNG, NumPy arrays."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.output.targets import check_folders, check_places
from nmaptool.io.output.writing import write_together
from nmaptool.io.pictures.height_arrays import CORNER_RECORD
from nmaptool.io.pictures.metadata import PREFIX, one_line
from nmaptool.io.stores.height_windows import HeightRange, HeightSource, blocks, range_of, samples_of
from nmaptool.maps.codec import encode_grey, grey_codes

EXPORT_ENDINGS = (".tif", ".tiff", ".npy")
TIFF_TILE_PX = 512
PNG_TILE_PX = 2048
INDEX_NAME = "tiles.json"
_ALPHA_UNASSOCIATED = "unassalpha"
_FOLDER_NEEDED = "tiles are written into a folder; give another name"


def export_heights(
    source: HeightSource,
    output: str | Path,
    *,
    found: HeightRange | None = None,
    tile_px: int | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> HeightRange:
    """Write heights window by window, in memory that does not depend on their number.

    Parameters
    ----------
    source : HeightSource
    output : str or Path
        By ending: ``.tif`` a BigTIFF of float32 mm in tiles; ``.npy`` an array that can be memory-mapped, NaN outside
        the surface (heights at corners: records, as `nmaptool.io.pictures.height_arrays` describes); without an ending
        a folder of tiles ``tile_ROW_COLUMN.png`` with 16-bit codes, black and white at the same heights in all tiles,
        which each file and the index ``tiles.json`` state.
    found : HeightRange, optional
        Default: all heights are read once before.
    tile_px : int, optional
        Side of a tile. Default: 512 in a TIFF, where it is a multiple of 16, and 2048 for PNG.
    overwrite : bool
        Replace files that exist.
    progress : callable, optional
        Called with "range" or "writing" and the share done.

    Returns
    -------
    HeightRange

    Raises
    ------
    UsageError
        If the ending or the side of a tile is not supported.
    InputError
        If there is no height, or one is infinite.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.
    """
    path = Path(output)
    ending = path.suffix.lower()
    side = (TIFF_TILE_PX if ending else PNG_TILE_PX) if tile_px is None else tile_px
    _check(path, ending, side)
    jobs, folders = _jobs(source, path, ending, side, overwrite)
    found = range_of(source, progress) if found is None else found
    write_together([(place, partial(write, found, progress)) for place, write in jobs], overwrite, folders)
    return found


def check_export(output: str | Path, overwrite: bool) -> None:
    """Refuse a file or folder that `export_heights` would refuse, before there are heights.

    Raises
    ------
    UsageError, OutputError
    """
    path = Path(output)
    ending = path.suffix.lower()
    _check(path, ending, TIFF_TILE_PX)
    if ending:
        check_places([path], overwrite)
        return
    check_folders([path], _FOLDER_NEEDED)
    check_places([path / INDEX_NAME, path / tile_name(0, 0)], overwrite, [path])


_Write = Callable[[HeightRange, "Progress | None", Path], None]


def _check(path: Path, ending: str, side: int) -> None:
    if ending not in ("", *EXPORT_ENDINGS):
        raise UsageError(
            f"{path}: ends in {path.suffix}; heights of a large map are written as {', '.join(EXPORT_ENDINGS)}, or as "
            "tiles of PNG into a folder, such as tiles"
        )
    if side < 16 or (ending and side % 16):
        raise UsageError(f"`tile_px={side}`: use a multiple of 16 for TIFF, and at least 16, such as `tile_px=512`")


def _jobs(
    source: HeightSource, path: Path, ending: str, side: int, overwrite: bool
) -> tuple[list[tuple[Path, _Write]], list[Path]]:
    """The files and how each is written, and the folders for them."""
    if not ending:
        jobs = list(_tile_jobs(source, path, side))
        check_folders([path], _FOLDER_NEEDED)
        check_places([place for place, _ in jobs], overwrite, [path])
        return jobs, [path]
    check_places([path], overwrite)
    if ending == ".npy":
        return [(path, partial(_write_npy, source))], []
    return [(path, partial(_write_tiff, source, side))], []


def facts_of(source: HeightSource, found: HeightRange) -> dict[str, str]:
    """The metadata of heights, as `nmaptool.io.pictures.heights.height_attributes`."""
    facts = {
        "kind": "height",
        "unit": "mm",
        "pitch_mm": repr(float(source.pitch_mm)),
        "height_min_mm": repr(found.low_mm),
        "height_max_mm": repr(found.high_mm),
        "version": __version__,
    }
    return {**facts, "at": "corners"} if source.at == "corners" else facts


def _write_tiff(source: HeightSource, side: int, found: HeightRange, progress: Progress | None, path: Path) -> None:
    """A BigTIFF of float32 in tiles, with alpha if there are gaps."""
    import tifffile

    lines = (f"{PREFIX}{key}={one_line(value)}" for key, value in facts_of(source, found).items())
    shape = (source.rows, source.cols, 2) if found.has_gaps else (source.rows, source.cols)
    with tifffile.TiffWriter(path, bigtiff=True) as tiff:
        tiff.write(
            _tiff_tiles(source, side, found, progress),
            shape=shape,
            dtype=np.float32,
            tile=(side, side),
            photometric="minisblack",
            planarconfig="contig" if found.has_gaps else None,
            extrasamples=[_ALPHA_UNASSOCIATED] if found.has_gaps else None,
            compression="zlib",
            compressionargs={"level": 1},
            description="\n".join(lines),
            software="nmaptool",
            metadata=None,
        )
    if progress is not None:
        progress("writing", 1.0)


def _tiff_tiles(
    source: HeightSource, side: int, found: HeightRange, progress: Progress | None
) -> Iterator[NDArray[np.float32]]:
    """The tiles row by row; those at the right and the lower edge are filled up."""
    channels = 2 if found.has_gaps else 1
    for rows, cols in blocks(source, side):
        z_mm, alpha = samples_of(source, rows, cols, has_gaps=found.has_gaps)
        for left in range(0, cols.stop - cols.start, side):
            part = z_mm[:, left : left + side]
            tile = np.zeros((side, side, channels), np.float32)
            tile[: part.shape[0], : part.shape[1], 0] = part
            if alpha is not None:
                tile[: part.shape[0], : part.shape[1], 1] = alpha[:, left : left + side]
            yield tile if channels == 2 else tile[..., 0]
        if progress is not None and rows.stop < source.rows:
            progress("writing", rows.stop / source.rows)


def _write_npy(source: HeightSource, found: HeightRange, progress: Progress | None, path: Path) -> None:
    """An array, or records of heights at corners. It is not mapped here: a full disk would end the process."""
    is_records = source.at == "corners"
    kind = CORNER_RECORD if is_records else source.window(slice(0, 1), slice(0, 1)).dtype
    header = {"descr": np.lib.format.dtype_to_descr(kind), "fortran_order": False, "shape": (source.rows, source.cols)}
    with path.open("wb") as stream:
        np.lib.format.write_array_header_2_0(stream, header)
        first = stream.tell()
        for rows, cols in blocks(source):
            values = _records(source, rows, cols) if is_records else source.window(rows, cols)
            for number, row in enumerate(np.ascontiguousarray(values, kind), start=rows.start):
                stream.seek(first + (number * source.cols + cols.start) * kind.itemsize)
                stream.write(row.tobytes())
            if progress is not None:
                progress("writing", rows.stop / source.rows)


def _records(source: HeightSource, rows: slice, cols: slice) -> NDArray[Any]:
    """A window as `CORNER_RECORD`."""
    z_mm, alpha = samples_of(source, rows, cols, has_gaps=True)
    assert alpha is not None
    out = np.zeros(z_mm.shape, CORNER_RECORD)
    out["z_mm"], out["inside"] = z_mm, alpha == 1
    return out


def _tile_jobs(source: HeightSource, folder: Path, side: int) -> Iterator[tuple[Path, _Write]]:
    """Every tile, and the index."""
    down, across = -(-source.rows // side), -(-source.cols // side)
    for row in range(down):
        for col in range(across):
            window = (
                slice(row * side, min((row + 1) * side, source.rows)),
                slice(col * side, min((col + 1) * side, source.cols)),
            )
            share = (row * across + col + 1) / (down * across)
            yield folder / tile_name(row, col), partial(_write_tile, source, window, share)
    yield folder / INDEX_NAME, partial(_write_index, source, side)


def tile_name(row: int, col: int) -> str:
    """The file of a tile.

    >>> tile_name(0, 3)
    'tile_0_3.png'
    """
    return f"tile_{row}_{col}.png"


def _write_tile(
    source: HeightSource,
    window: tuple[slice, slice],
    share: float,
    found: HeightRange,
    progress: Progress | None,
    path: Path,
) -> None:
    from nmaptool.io.pictures.writer import write_image

    z_mm, alpha = samples_of(source, *window, has_gaps=found.has_gaps)
    span = found.high_mm - found.low_mm
    shares = (z_mm.astype(np.float64) - found.low_mm) / span if span > 0 else np.zeros(z_mm.shape)
    facts = {**facts_of(source, found), "top_px": str(window[0].start), "left_px": str(window[1].start)}
    if alpha is None:
        write_image(grey_codes(shares, 16)[..., None], path, ("Y",), facts)
    else:
        codes = grey_codes(np.where(alpha > 0, shares, 0), 16)
        write_image(np.dstack([codes, encode_grey(alpha, 16)]), path, ("Y", "A"), facts)
    if progress is not None:
        progress("writing", share)


def _write_index(source: HeightSource, side: int, found: HeightRange, progress: Progress | None, path: Path) -> None:
    """What all tiles share, as JSON."""
    index: Mapping[str, Any] = {
        "kind": "height tiles",
        "version": __version__,
        "unit": "mm",
        "files": "tile_{row}_{col}.png",
        "tile_px": side,
        "tile_rows": -(-source.rows // side),
        "tile_cols": -(-source.cols // side),
        "rows": source.rows,
        "cols": source.cols,
        "pitch_mm": float(source.pitch_mm),
        "at": source.at,
        "bits": 16,
        "black_mm": found.low_mm,
        "white_mm": found.high_mm,
        "alpha": found.has_gaps,
    }
    path.write_text(json.dumps(index, indent=2) + "\n", encoding="utf-8", newline="\n")

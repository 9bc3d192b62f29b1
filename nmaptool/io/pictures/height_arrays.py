"""Height fields as NumPy array files, .npy.

A plain two-dimensional array holds heights at centres, NaN outside the surface. The format has no metadata, so a plain
array of heights at corners would be read as a picture one pixel larger. Heights at corners are therefore stored as
records with named fields, `CORNER_RECORD`, which no reader takes for a picture. ``np.load(path)["z_mm"]`` is the plain
array.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, OutputError, reason_of
from nmaptool.io.pictures.array_files import ArrayHeader, header_of, load_npy
from nmaptool.io.pictures.height_samples import height_of_centers, height_of_corners
from nmaptool.io.pictures.size_limit import check_size
from nmaptool.types.height import Height

# a corner's height in mm, and whether the pixel to its lower right belongs to the surface
CORNER_RECORD = np.dtype([("z_mm", "<f8"), ("inside", "?")])


def write_centers(height: Height, path: Path) -> None:
    """Write (H, W) float64 heights in mm at pixel centres, NaN outside the surface.

    Raises
    ------
    OutputError
    """
    _save(path, height.at_pixels())


def write_corners(height: Height, path: Path) -> None:
    """Write (H+1, W+1) records of `CORNER_RECORD`.

    Raises
    ------
    OutputError
    """
    records = np.zeros(height.z_mm.shape, CORNER_RECORD)
    records["z_mm"] = height.z_mm
    records["inside"][:-1, :-1] = height.domain
    _save(path, records)


def _save(path: Path, values: NDArray[Any]) -> None:
    try:
        with path.open("wb") as stream:
            np.save(stream, values, allow_pickle=False)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None


def read_height_array(path: Path, pitch_mm: float | None, max_megapixels: float, *, with_gaps: bool = False) -> Height:
    """Read heights at centres or at corners, whichever the file holds.

    Raises
    ------
    InputError
        If it is not an array file, does not hold heights, or holds NaN or infinite heights.
    LimitError
        If it is larger than ``max_megapixels``.
    """
    values = _load(path, max_megapixels)
    if values.dtype.names is None:
        return height_of_centers(str(path), values.astype(np.float64), None, pitch_mm, with_gaps=with_gaps)
    return height_of_corners(str(path), values["z_mm"].astype(np.float64), values["inside"], pitch_mm)


def is_height_array(path: Path) -> bool:
    """Whether an .npy file holds heights: a two-dimensional array, or records of heights at corners.

    Raises
    ------
    InputError
    """
    return len(header_of(path).shape) == 2


def _load(path: Path, max_megapixels: float) -> NDArray[Any]:
    def check(name: str, header: ArrayHeader) -> None:
        if len(header.shape) != 2 or not _holds_heights(header.kind) or 0 in header.shape:
            raise InputError(f"{name}: must hold one (rows, columns) array of heights in mm")
        check_size(path, header.shape[1], header.shape[0], max_megapixels)

    return load_npy(path, check)


def _holds_heights(kind: np.dtype[Any]) -> bool:
    """Whether an array is of plain numbers, or of records with the fields of `CORNER_RECORD`."""
    if kind.names is None:
        return kind.kind in "fiu"
    return kind.names == CORNER_RECORD.names and kind["z_mm"].kind == "f" and kind["inside"].kind == "b"

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
from nmaptool.io.pictures.height_samples import height_of_centers, height_of_corners
from nmaptool.io.pictures.png import check_size
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


def read_height_array(path: Path, pitch_mm: float | None, max_megapixels: float) -> Height:
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
        return height_of_centers(str(path), values.astype(np.float64), None, pitch_mm)
    return height_of_corners(str(path), values["z_mm"].astype(np.float64), values["inside"], pitch_mm)


def _load(path: Path, max_megapixels: float) -> NDArray[Any]:
    not_ours = InputError(f"{path}: is not a NumPy array file, or is truncated; save it again")
    try:
        if path.is_dir():  # Windows reports a folder as a protected file
            raise InputError(f"{path}: is a folder; give a height file")
        with path.open("rb") as stream:
            if not stream.read(6) == np.lib.format.MAGIC_PREFIX:
                raise not_ours
            stream.seek(0)
            version = np.lib.format.read_magic(stream)
            reader = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            shape, _, kind = reader(stream)
            if len(shape) != 2 or not _holds_heights(kind) or 0 in shape:
                raise InputError(f"{path}: must hold one (rows, columns) array of heights in mm")
            check_size(path, shape[1], shape[0], max_megapixels)
            stream.seek(0)
            values: NDArray[Any] = np.load(stream, allow_pickle=False)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, EOFError):
        raise not_ours from None
    return values


def _holds_heights(kind: np.dtype[Any]) -> bool:
    """Whether an array is of plain numbers, or of records with the fields of `CORNER_RECORD`."""
    if kind.names is None:
        return kind.kind in "fiu"
    return kind.names == CORNER_RECORD.names and kind["z_mm"].kind == "f" and kind["inside"].kind == "b"
